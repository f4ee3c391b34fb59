#!/bin/sh
# calculix.sh BUILD DIR: CalculiX as the host, by files. A cube of 4^3 elements, its top held, is pressed and
# sheared onto a rough floor. ccx writes K (job.sti, job.dof); `delassus solve` takes it with a list of
# the nodes at the bottom and of the loads. Beside it ccx solves the same block with its penalty contact,
# node to surface, as the stiffness of the contact grows: the distance of all displacements falls.
#
# Output:
#   delassus: free 10, slip 7, stick 8
#   contact stiffness 1e4: ccx differs by 7e-02 of the largest displacement
#   contact stiffness 1e5: ccx differs by 8e-03 of the largest displacement
#   contact stiffness 1e6: ccx differs by 8e-04 of the largest displacement
#   contact stiffness 1e7: ccx differs by 2e-04 of the largest displacement
#
set -eu
program=$PWD/$1/delassus
mkdir -p "$2"
cd "$2"
# nodes, elements and sets of the cube; node 1 + i + 5 j + 25 k
awk -v side=4 'BEGIN {
  n = side + 1
  print "*NODE, NSET=NALL"
  for (k = 0; k < n; k++) for (j = 0; j < n; j++) for (i = 0; i < n; i++)
    printf "%d, %.8f, %.8f, %.8f\n", 1 + i + n * (j + n * k), i / side, j / side, k / side
  print "*ELEMENT, TYPE=C3D8, ELSET=EALL"
  for (k = 0; k < side; k++) for (j = 0; j < side; j++) for (i = 0; i < side; i++) {
    a = 1 + i + n * (j + n * k); b = a + n * n
    printf "%d, %d, %d, %d, %d, %d, %d, %d, %d\n", ++e, a, a + 1, a + 1 + n, a + n, b, b + 1, b + 1 + n, b + n
  }
  print "*NSET, NSET=TOP, GENERATE\n101, 125\n*NSET, NSET=BOTTOM, GENERATE\n1, 25"
  print "*MATERIAL, NAME=M\n*ELASTIC\n1000, 0.25\n*DENSITY\n1\n*SOLID SECTION, ELSET=EALL, MATERIAL=M"
  print "*BOUNDARY\nTOP, 1, 3" }' > block.inc
# loads on the nodes half way up; the list of contact nodes with their normals
awk 'BEGIN { for (j = 0; j < 5; j++) for (i = 0; i < 5; i++) {
  node = 51 + i + 5 * j
  print node, 1, 2e-5; print node, 3, 5e-5 - 25e-5 * i / 4 } }' > loads.txt
awk 'BEGIN { for (node = 1; node <= 25; node++) print node, 0, 0, 1 }' > nodes.txt
printf '%s\n' '*INCLUDE, INPUT=block.inc' '*STEP' '*FREQUENCY, SOLVER=MATRIXSTORAGE' 1 '*END STEP' > job.inp
ccx job > job.log 2>&1 || [ -s job.sti ]
"$program" solve --stiffness job.sti --nodes nodes.txt --f loads.txt --mu 0.3 --csv . > solve.log
grep free solve.log | sed 's/^ */delassus: /'
for stiffness in 1e4 1e5 1e6 1e7; do
  { # a floor of one held element below, and the contact
    printf '%s\n' '*INCLUDE, INPUT=block.inc' '*NODE, NSET=FLOOR'
    awk 'BEGIN { for (k = 0; k < 2; k++) for (j = 0; j < 2; j++) for (i = 0; i < 2; i++)
      printf "%d, %g, %g, %g\n", ++m + 1000, i == (j == 0) ? 3 : -2, 5 * j - 2, k - 1 }'
    printf '%s\n' '*ELEMENT, TYPE=C3D8, ELSET=EFLOOR' '1001, 1001, 1002, 1003, 1004, 1005, 1006, 1007, 1008' \
      '*SOLID SECTION, ELSET=EFLOOR, MATERIAL=M' '*BOUNDARY' 'FLOOR, 1, 3' \
      '*SURFACE, NAME=SLAVE, TYPE=NODE' BOTTOM '*SURFACE, NAME=MASTER' '1001, S2' \
      '*SURFACE INTERACTION, NAME=I' '*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR' "$stiffness, 1e-9" \
      '*FRICTION' "0.3, $stiffness" \
      '*CONTACT PAIR, INTERACTION=I, TYPE=NODE TO SURFACE' 'SLAVE, MASTER' \
      '*STEP, INC=1000' '*STATIC' '1, 1' '*CLOAD'
    sed 's/ /, /g' loads.txt
    printf '%s\n' '*NODE PRINT, NSET=NALL, GLOBAL=YES' U '*END STEP'
  } > pen.inp
  ccx pen > pen.log 2>&1 || { echo "ccx: $stiffness: $(tail -3 pen.log)"; exit 1; }
  # x.csv: node,direction,x; pen.dat: node ux uy uz
  awk -v stiffness=$stiffness 'FNR == NR { split($0, v, ","); if (FNR > 1) x[v[1] "." v[2]] = v[3]; next }
    NF == 4 && $1 + 0 > 0 { for (k = 1; k <= 3; k++) if (($1 "." k) in x) {
      d = $(k + 1) - x[$1 "." k]; if (d < 0) d = -d; if (d > apart) apart = d
      a = x[$1 "." k]; if (a < 0) a = -a; if (a > size) size = a } }
    END { printf "contact stiffness %s: ccx differs by %.0e of the largest displacement\n", stiffness, apart / size }' x.csv pen.dat
done
