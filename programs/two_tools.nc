%
(Holes and the outline of a plate of 40 x 30 x 5 mm, with two tools, as CAM programs write it)
(T1 D=3. drill)
(T2 D=6. flat end mill)
; Two lines that no CAM program writes make it run as it is on the parking gantry, with the plate in front of the rack:
$H                    ; find the zero of every axis
G10 L2 P1 X20 Y20 Z20 ; work zero: the lower left corner of the plate, on its surface

G90 G94 G17
G21
G40 G49 G80
G54

(Four holes)
T1 M6 (3 mm drill)
S800 M3
G0 X8 Y8
G43 H1 Z5
G98 G81 Z-2 R2 F600
X32
G83 Y22 Z-6 R2 Q4
X8
G80
M5

(Outline)
T2 M6 (6 mm flat end mill)
S500 M3
G0 X-8 Y15
G43 H2 Z5
G1 Z-5.2 F600
X-3 F1800
Y27
G2 X3 Y33 I6
G1 X37
G2 X43 Y27 J-6
G1 Y3
G2 X37 Y-3 I-6
G1 X3
G2 X-3 Y3 J6
G1 Y15
X-8
G0 Z5
M5
X0 Y0
M30
%
