; Diagonals that are hard on an interpolator: unequal distances, a single step, no step at all.
; Needs no homing and no switches. One step is 0.02 mm.
G21 G91 G94           ; millimetres, relative, feed in mm/min
G0 X100 Y37           ; 5000 and 1850 steps
G0 X0.02 Y60          ; one step of X while Y makes 3000
G0 X40 Y0.02          ; and the other way round
G0 X0.02 Y0.02        ; one step each
G0 X0.02              ; one step, Y at rest
G0 X0.005             ; less than half a step: nothing moves
G1 X-70.02 Y-0.06 F1800 ; 3501 steps against 3
G1 X0.14 Y-0.22 Z0.26 ; 7, 11 and 13 steps
G1 X29.98 Y3.3 Z20    ; three axes, 1499, 165 and 1000 steps
G0 X-100.16 Y-100.06 Z-20.26 ; and back to where it began, all three at once
