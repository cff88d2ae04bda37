; A target that a laser engraves: squares in each other, from 20 % to full power. Needs no homing and no switches.
; cargo xtask sim programs/engraving.nc --report report
; From here on the tool is a laser, and S is the level of each move.
$32=1
G21 G91 G94           ; millimetres, relative, feed in mm/min
M4 S0                 ; the level follows the speed, so that corners are no darker

G1 F1200
S200
X40
Y40
X-40
Y-40
G0 X4 Y4              ; dark, as every rapid move
G1 S400
X32
Y32
X-32
Y-32
G0 X4 Y4
G1 S600
X24
Y24
X-24
Y-24
G0 X4 Y4
G1 S800
X16
Y16
X-16
Y-16
G0 X4 Y4
G1 S1000
X8
Y8
X-8
Y-8
M5
G0 X-16 Y-16
M2
