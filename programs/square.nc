; A square of 100 mm from wherever the machine stands: needs no homing and no switches.
G21 G91 G94           ; millimetres, relative, feed in mm/min
G1 X100 F2400
G1 Y100
G1 X-100
G1 Y-100
