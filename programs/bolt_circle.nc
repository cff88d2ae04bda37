; Holes on a circle, by parameters and a subroutine: for the parking gantry's travel. docs/programs.md explains it.

$H                               ; find the zero of every axis
#<holes> = 6
#<radius> = 40                   ; mm
#<_depth> = 12                   ; mm; a name that begins with _ is known in subroutines too
#<_peck> = 5                     ; mm

o<hole> sub                      ; a hole at X #1, Y #2, in steps of the peck
  G0 X#1 Y#2
  #3 = 0
  o110 while [#3 LT #<_depth>]
    #3 = [#3 + #<_peck>]
    o120 if [#3 GT #<_depth>]
      #3 = #<_depth>
    o120 endif
    G1 Z[30 - #3] F600
    G0 Z32
  o110 endwhile
o<hole> endsub

G21 G90 G17 G94
G0 X175 Y200 Z32
#1 = 0
o100 repeat [#<holes>]
  o<hole> call [175 + #<radius> * COS[#1]] [200 + #<radius> * SIN[#1]]
  #1 = [#1 + 360 / #<holes>]
o100 endrepeat
G0 X175 Y200
M2
