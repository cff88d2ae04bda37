; Parking gantry: home, fetch a car at the pick-up point, store it in a bay, return for the next one.
;
; The machine travels X 0 to 350 mm (across), Y 0 to 400 mm (up) and Z 0 to 100 mm (into the rack).
; The rack has 3 x 3 bays of 150 x 80 mm. It is 450 mm wide and the carriage reaches 350 mm of that, the
; middle of every bay, which is where the fork has to be:
;
;   columns at X 25, 175, 325      rows at Y 160, 240, 320      pick-up point at X 175, Y 40
;
; The fork goes in low, lifts the car by 10 mm and draws back; to set it down it goes in high.

$H                    ; find the zero of every axis: Z first, so that the fork is drawn back
G21 G90 G94           ; millimetres, absolute, feed in mm/min

; Fetch the car.
G0 X175 Y40           ; in front of the pick-up point
G1 Z90 F1800          ; fork in, under the car
G1 Y50 F1200          ; lift it
G1 Z0 F1800           ; draw it out

; Store it in the bay on the right of the top row.
G1 X325 Y330 F2400    ; carry it there, in a straight line, lifted
G1 Z90 F1800          ; put it in
G1 Y320 F1200         ; set it down
G1 Z0 F1800           ; fork out

; Return for the next car.
G0 X175 Y40
