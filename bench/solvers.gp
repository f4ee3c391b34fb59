# solvers.gp: a picture of bench/solvers from its data in `dir`: the time of ours over that of the best of
# Siconos, scene by scene. The colours tell sets, not methods.
if (!exists('dir')) dir = 'bench/results/'
tols = '1e-04 1e-08 1e-12'
set grid
set terminal pngcairo size 1500,600 font ',12'
set output dir.'solvers_ratio.png'
set multiplot layout 1,3 title 'CPU time of delassus auto over that of the best solver of Siconos for the scene; below 1: delassus is faster'
set logscale xy
set xrange [0.8:10000]
set yrange [0.002:100]
set format xy '10^{%T}'
set xlabel 'candidates' offset 0,0.6
set ylabel 'ratio'
set key outside bottom center horizontal
do for [tol in tols] {
  set title 'residual '.tol
  plot 1 with lines lc rgb '#404040' dt 2 notitle, \
      for [i=0:5] dir.'ratio_'.tol.'.dat' index i using 1:2 with points pt (word('1 7 5 9 13 2', i+1)+0) \
          ps 1.1 lc rgb word('#808080 #1b4f9c #2a9d8f #c0202a #e9a820 #6a4c93', i+1) title columnheader(1)
}
unset multiplot
unset logscale
unset output
