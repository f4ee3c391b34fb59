# lemke.gp: lemke.csv -> lemke.png, in `dir`.
# The colours are of src/cli/palette.c: blue ones are delassus, warm ones the peers, grey is BLAS.
if (!exists('dir')) dir = 'bench/results/'
data = dir.'lemke.csv'
set datafile separator ','
set datafile missing NaN # the line goes on over it
set logscale xy
set key left top reverse Left
set grid
set xlabel 'n'
set xrange [60:8000]
set offsets 0, 0, graph 0.1, 0
set format y '10^{%T}'
# column c of the rows of problem p; only where it was solved (column s)
pick(p, c, s) = strcol(1) eq p && column(s) == 1 ? column(c) : NaN
label(p) = strcol(1) eq p && column(17) > 0 ? sprintf('%.0f, %.0f', column(16), column(17)) : ''
set terminal pngcairo size 1300,620 font ',12'
set output dir.'lemke.png'
set multiplot layout 1,2
set title 'CPU time of a solve; numbers: Siconos / path, Siconos / crash start'
set ylabel 's'
plot data using 2:(pick('random', 12, 15)) with linespoints pt 6 lc rgb '#d55e00' title 'Siconos, random', \
     '' using 2:(pick('friction', 12, 15)) with linespoints pt 4 dt 2 lc rgb '#d55e00' title 'Siconos, friction', \
     '' using 2:(pick('random', 4, 7)) with linespoints pt 7 lc rgb '#0072b2' title 'path, random', \
     '' using 2:(pick('friction', 4, 7)) with linespoints pt 5 dt 2 lc rgb '#0072b2' title 'path, friction', \
     '' using 2:(pick('random', 8, 11)) with linespoints pt 13 lc rgb '#56b4e9' title 'crash start, random', \
     '' using 2:(pick('friction', 8, 11)) with linespoints pt 9 dt 2 lc rgb '#56b4e9' title 'crash start, friction', \
     '' using 2:(pick('random', 12, 15)):(label('random')) with labels offset -1,1 tc rgb '#d55e00' notitle, \
     '' using 2:(pick('friction', 12, 15)):(label('friction')) with labels left offset 1.2,-0.4 tc rgb '#d55e00' notitle
set title 'The path: time per exchange beside BLAS on n x (n+1)'
set ylabel 's'
plot data using 2:(pick('random', 18, 7)) with linespoints pt 7 lc rgb '#0072b2' title 'delassus, random', \
     '' using 2:(pick('friction', 18, 7)) with linespoints pt 5 dt 2 lc rgb '#0072b2' title 'delassus, friction', \
     '' using 2:(pick('random', 19, 7)) with linespoints pt 8 lc rgb '#999999' title 'dger', \
     '' using 2:(pick('random', 20, 7)) with linespoints pt 10 dt 2 lc rgb '#999999' title 'dgemv'
unset multiplot
unset output
