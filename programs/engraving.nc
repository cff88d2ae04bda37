; A car of 54 x 19 mm, drawn by a laser from wherever the machine stands: needs no homing and no switches.
; First tell the machine that its tool is a laser: $32=1. S1000 is the laser's full power ($30).
G21 G91 G94           ; millimetres, relative, feed in mm/min
M4 S0                 ; power by speed: where the machine slows down, at corners, it burns no more than elsewhere
G0 X2 Y5              ; the laser is dark in every G0

; The body in one stroke, clockwise from the rear bumper: wheel arches, bonnet, roof. Its windows are faint.
G1 X6 F1200 S900
G2 X12 I6
G1 X18
G2 X12 I6
G1 X6
G1 Y7
G1 X-12 Y2 S700
G1 X-8 Y6 S300
G1 X-19 S700
G1 X-8 Y-6 S300
G1 X-7 Y-2 S700
G1 Y-7 S900

; The wheels.
G0 X8
G2 X0 I4 S600
G0 X30
G2 X0 I4

M5                    ; laser off
G0 X-40 Y-5           ; to where it began
M2
