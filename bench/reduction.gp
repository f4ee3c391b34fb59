# reduction.gp: reduction.csv -> reduction.png, in `dir`.
# The colours are of src/cli/palette.c: blue ones are delassus, warm ones the peers, grey is BLAS.
if (!exists('dir')) dir = 'bench/results/'
data = dir.'reduction.csv'
set datafile separator ','
set datafile missing NaN # the line goes on over it
set logscale xy
set key left top reverse Left
set grid
set xlabel 'unknowns'
set offsets 0, 0, graph 0.25, 0
# column c of the rows of kind k, dimension d, way w
pick(k, d, w, c) = strcol(1) eq k && column(2) == d && strcol(6) eq w ? column(c) : NaN
set terminal pngcairo size 1500,560 font ',12'
set output dir.'reduction.png'
set multiplot layout 1,3
set title 'W of a 3D elastic box: CPU time, one thread'
set ylabel 's'
plot data using 4:(pick('definite', 3, 'columns', 7)) with linespoints pt 6 lc rgb '#d55e00' title 'CHOLMOD, 64 columns at a time', \
     '' using 4:(pick('definite', 3, 'delassus', 7)) with linespoints pt 7 lc rgb '#0072b2' title 'delassus', \
     '' using 4:(pick('unsymmetric', 3, 'columns', 7)) with linespoints pt 8 lc rgb '#e69f00' title 'UMFPACK, unsymmetric', \
     '' using 4:(pick('unsymmetric', 3, 'delassus', 7)) with linespoints pt 9 lc rgb '#56b4e9' title 'delassus, unsymmetric'
set title 'Peak memory'
set ylabel 'GB'
plot data using 4:(pick('definite', 3, 'columns', 8)) with linespoints pt 6 lc rgb '#d55e00' title 'CHOLMOD, 64 columns at a time', \
     '' using 4:(pick('definite', 3, 'delassus', 8)) with linespoints pt 7 lc rgb '#0072b2' title 'delassus', \
     '' using 4:(pick('definite', 3, 'delassus', 9)) with lines dt 3 lc rgb '#0072b2' title 'as foreseen'
set title 'Operations per second'
set ylabel '10^9 / s'
plot data using 4:(pick('definite', 3, 'delassus', 18)) with linespoints pt 8 lc rgb '#999999' title 'dgemm', \
     '' using 4:(pick('definite', 3, 'delassus', 17)) with linespoints pt 7 lc rgb '#0072b2' title 'delassus, 3D', \
     '' using 4:(pick('definite', 2, 'delassus', 17)) with linespoints pt 5 dt 2 lc rgb '#0072b2' title 'delassus, 2D'
unset multiplot
unset output
