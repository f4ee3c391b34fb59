# global.gp: global.csv -> global.png, in `dir`.
# The colours are of src/cli/palette.c.
if (!exists('dir')) dir = 'bench/results/'
data = dir.'global.csv'
set datafile separator ','
set datafile missing NaN
set logscale xy
set grid
set key left top reverse Left
set xlabel 'contacts / unknowns'
set ylabel 'CPU of W / CPU of K'
set xrange [0.006:0.3]
set yrange [0.4:100]
set xtics (0.01, 0.02, 0.05, 0.1, 0.2)
set ytics (0.5, 1, 2, 5, 10, 20, 50, 100)
pick(d, s) = column(1) == d && column(2) == s ? column(7) / column(6) : NaN
set terminal pngcairo size 1200,560 font ',12'
set output dir.'global.png'
set multiplot layout 1,2
set title 'Strips of 1 to 64 elements across, 2D'
plot 1 with lines dt 2 lc rgb '#999999' title 'as fast', \
     for [k=1:5] data using (column(5)/column(4)):(pick(2, word('60 120 250 500 1000', k) + 0)) with linespoints pt 7 lc rgb word('#56b4e9 #0072b2 #e69f00 #d55e00 #000000', k) title word('60 120 250 500 1000', k).' contacts'
set title 'Plates of 1 to 16 elements across, 3D'
plot 1 with lines dt 2 lc rgb '#999999' title 'as fast', \
     for [k=1:5] data using (column(5)/column(4)):(pick(3, word('6 10 16 24 32', k) + 0)) with linespoints pt 7 lc rgb word('#56b4e9 #0072b2 #e69f00 #d55e00 #000000', k) title sprintf('%d contacts', (word('6 10 16 24 32', k) + 1)**2)
unset multiplot
unset output
