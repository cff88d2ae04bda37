; Arcs of all kinds, for the parking gantry's travel: X 0 to 350 mm, Y 0 to 400 mm, Z 0 to 100 mm.
; Every figure begins and ends at X 150, Y 200, Z 20.

$H                    ; find the zero of every axis
G21 G90 G17 G94       ; millimetres, absolute, arcs in the plane of X and Y, feed in mm/min
G0 X150 Y200 Z20
F1800

; A full circle by its centre, both ways round.
G2 X150 Y200 I20      ; clockwise around X 170, Y 200
G3 X150 Y200 J-15     ; the other way round X 150, Y 185

; A square of 60 mm with round corners, by their radius.
G1 X170
G2 X180 Y190 R10
G1 Y150
G2 X170 Y140 R10
G1 X130
G2 X120 Y150 R10
G1 Y190
G2 X130 Y200 R10
G1 X150

; The same two places by the short way and, with a radius below zero, by the long way.
G3 X170 Y200 R25
G3 X150 Y200 R-25

; A helix: two turns up, and one down again.
G3 X150 Y200 I-12 Z30
G3 X150 Y200 I-12 Z40
G2 X150 Y200 I-12 Z20

; Arcs that stand upright, in the plane of Z and X and in that of Y and Z, relative, and one in inches.
G91
G18 G2 X20 Z20 K20
G3 X-20 Z-20 I-20
G19 G2 Y15 Z15 J15
G3 Y-15 Z-15 K-15
G20 G18 G3 X1 R.5 F60
G2 X-1 R.5

; A circle five times a minute, and a stop at the end of each of two half circles.
G21 G90 G17
G93 G2 X150 Y200 I10 F5
G94 G61.1 G2 X180 I15 F1800
G2 X150 I-15
G61
