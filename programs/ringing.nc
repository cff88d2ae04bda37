; Corners that make ringing visible, at three speeds: docs/ringing.md says how to read the lines that they draw.
; Draw with a pen or a weak laser. It takes 60 by 50 mm to the right of where the machine stands, and needs no homing.
G21 G91 G94           ; millimetres, relative, feed in mm/min
G1 F1200              ; 20 mm/s
Y20
X60                   ; look at the waves at the beginning of this line
G0 X-60 Y-5
G1 F3000              ; 50 mm/s
Y20
X60
G0 X-60 Y-5
G1 F6000              ; 100 mm/s
Y20
X60
G0 X-60 Y-50
M2
