# solvers.gp: the pictures of bench/solvers from its data in `dir`: performance profiles for 2D and 3D, and
# the time of ours over that of the best of Siconos, scene by scene.
if (!exists('dir')) dir = 'bench/results/'
tols = '1e-04 1e-08 1e-12'
set grid
own = '#1b4f9c #2a9d8f #6a4c93 #8ab17d #e9a820 #5d6d7e #a05a2c'
peer = '#c0202a #f4793b #f2b705 #d12fa0 #7f0000 #ff7aa8 #7a4a12'
do for [i=0:13] {
  colour = i < 7 ? word(own, i+1) : word(peer, i-6)
  width = i == 0 || i == 7 ? 3.5 : 1.6
  dash = i < 8 ? 1 : 2
  set style line i+1 lw width dt dash lc rgb colour
}
do for [type in 'png svg'] {
  if (type eq 'png') { set terminal pngcairo size 1500,1150 font ',12' }
  if (type eq 'svg') { set terminal svg size 1500,1150 font ',12' background 'white' }

  set output dir.'solvers_profile.'.type
  set multiplot layout 2,3 title "Performance profiles: part of all scenes that a solver brings to the target within {/Symbol t} times the CPU time of the fastest\nlines: delassus; dashes: Siconos; thick: delassus auto, best of Siconos"
  set logscale x
  set xrange [1:1000]
  set yrange [0:1.02]
  set format x '10^{%T}'
  set xlabel '{/Symbol t}' offset 0,0.6
  set ylabel 'part of the scenes'
  set key outside bottom center horizontal samplen 2 maxcols 3 font ',10'
  do for [d in '2d 3d'] {
    do for [tol in tols] {
      set title (d eq '2d' ? '2D' : '3D').', residual '.tol
      plot for [i=0:13] dir.'profile_'.d.'_'.tol.'.dat' index i using 1:2 with steps ls i+1 \
          title columnheader(1)
    }
  }
  unset multiplot

  if (type eq 'png') { set terminal pngcairo size 1500,600 font ',12' }
  if (type eq 'svg') { set terminal svg size 1500,600 font ',12' background 'white' }
  set output dir.'solvers_ratio.'.type
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
}
