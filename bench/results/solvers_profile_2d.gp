set datafile missing 'NaN'
set key off
set grid lc rgb '#d8d8d8'
set encoding utf8
do for [type in 'png svg'] {
  if (type eq 'png') { set terminal pngcairo size 1800,1100 font ',13' }
  if (type eq 'svg') { set terminal svg size 1800,1100 font ',13' background 'white' }
  set output 'solvers_profile_2d.'.type
  set multiplot title "59 scenes in 2D: delassus, and dashed Siconos" font ',17' noenhanced
  set lmargin at screen 0.05
  set rmargin at screen 0.31533
  set bmargin at screen 0.575
  set tmargin at screen 0.92
  unset label
  unset arrow
  unset title
  set title '{/:Bold residual 1e-4}' offset 0,-0.6
  set logscale x
  unset logscale y
  set xrange [1:1000]
  set yrange [0:1.02]
  set format x '%g'
  set format y '%g'
  set xtics 10
  set ytics 0.2
  set xlabel 'CPU / fastest, at most' offset 0,0.5
  set ylabel 'part of the problems' offset 1,0
  set arrow from screen 0.0500,0.5170 to screen 0.0700,0.5170 nohead lw 4 dt 1 lc rgb '#000000'
  set label "auto".'  59/59' at screen 0.0750,0.5170 left font ',10' noenhanced
  set arrow from screen 0.0500,0.5010 to screen 0.0700,0.5010 nohead lw 1.8 dt 1 lc rgb '#0072b2'
  set label "newton".'  57/59' at screen 0.0750,0.5010 left font ',10' noenhanced
  set arrow from screen 0.0500,0.4850 to screen 0.0700,0.4850 nohead lw 1.8 dt 1 lc rgb '#56b4e9'
  set label "nlgs+anderson".'  59/59' at screen 0.0750,0.4850 left font ',10' noenhanced
  set arrow from screen 0.0500,0.4690 to screen 0.0700,0.4690 nohead lw 1.8 dt 1 lc rgb '#e69f00'
  set label "nlgs".'  59/59' at screen 0.0750,0.4690 left font ',10' noenhanced
  set arrow from screen 0.0500,0.4530 to screen 0.0700,0.4530 nohead lw 1.8 dt 1 lc rgb '#009e73'
  set label "admm".'  58/59' at screen 0.0750,0.4530 left font ',10' noenhanced
  set arrow from screen 0.0500,0.4370 to screen 0.0700,0.4370 nohead lw 1.8 dt 1 lc rgb '#d55e00'
  set label "augmented-lagrangian".'  57/59' at screen 0.0750,0.4370 left font ',10' noenhanced
  set arrow from screen 0.0500,0.4210 to screen 0.0700,0.4210 nohead lw 1.8 dt 1 lc rgb '#cc79a7'
  set label "lemke".'  53/57' at screen 0.0750,0.4210 left font ',10' noenhanced
  set arrow from screen 0.1906,0.5170 to screen 0.2106,0.5170 nohead lw 1.8 dt 2 lc rgb '#b00020'
  set label "best of Siconos".'  58/58' at screen 0.2156,0.5170 left font ',10' noenhanced
  set arrow from screen 0.1906,0.5010 to screen 0.2106,0.5010 nohead lw 1.8 dt 3 lc rgb '#7f0000'
  set label "Siconos NSGS".'  58/58' at screen 0.2156,0.5010 left font ',10' noenhanced
  set arrow from screen 0.1906,0.4850 to screen 0.2106,0.4850 nohead lw 1.8 dt 4 lc rgb '#ff5a7a'
  set label "Siconos NSN".'  3D only' at screen 0.2156,0.4850 left font ',10' noenhanced
  set arrow from screen 0.1906,0.4690 to screen 0.2106,0.4690 nohead lw 1.8 dt 5 lc rgb '#a0522d'
  set label "Siconos ADMM".'  3D only' at screen 0.2156,0.4690 left font ',10' noenhanced
  set arrow from screen 0.1906,0.4530 to screen 0.2106,0.4530 nohead lw 1.8 dt 2 lc rgb '#c71585'
  set label "Siconos PROX".'  3D only' at screen 0.2156,0.4530 left font ',10' noenhanced
  set arrow from screen 0.1906,0.4370 to screen 0.2106,0.4370 nohead lw 1.8 dt 3 lc rgb '#b00020'
  set label "Siconos CPG".'  44/57' at screen 0.2156,0.4370 left font ',10' noenhanced
  set arrow from screen 0.1906,0.4210 to screen 0.2106,0.4210 nohead lw 1.8 dt 4 lc rgb '#7f0000'
  set label "Siconos Lemke".'  39/57' at screen 0.2156,0.4210 left font ',10' noenhanced
  plot -1 with lines, \
       'solvers_profile_2d.dat' index 4 using 1:2 with steps lw 1.8 dt 1 lc rgb '#0072b2', \
       'solvers_profile_2d.dat' index 8 using 1:2 with steps lw 1.8 dt 1 lc rgb '#56b4e9', \
       'solvers_profile_2d.dat' index 12 using 1:2 with steps lw 1.8 dt 1 lc rgb '#e69f00', \
       'solvers_profile_2d.dat' index 16 using 1:2 with steps lw 1.8 dt 1 lc rgb '#009e73', \
       'solvers_profile_2d.dat' index 20 using 1:2 with steps lw 1.8 dt 1 lc rgb '#d55e00', \
       'solvers_profile_2d.dat' index 24 using 1:2 with steps lw 1.8 dt 1 lc rgb '#cc79a7', \
       'solvers_profile_2d.dat' index 28 using 1:2 with steps lw 1.8 dt 2 lc rgb '#b00020', \
       'solvers_profile_2d.dat' index 32 using 1:2 with steps lw 1.8 dt 3 lc rgb '#7f0000', \
       'solvers_profile_2d.dat' index 48 using 1:2 with steps lw 1.8 dt 3 lc rgb '#b00020', \
       'solvers_profile_2d.dat' index 52 using 1:2 with steps lw 1.8 dt 4 lc rgb '#7f0000', \
       'solvers_profile_2d.dat' index 0 using 1:2 with steps lw 4 dt 1 lc rgb '#000000'
  set lmargin at screen 0.05
  set rmargin at screen 0.31533
  set bmargin at screen 0.075
  set tmargin at screen 0.36
  unset label
  unset arrow
  unset title
  set title 'each problem, from quick to slow' offset 0,-0.6 font ',12'
  unset logscale x
  set logscale y
  set xrange [0:60]
  set yrange [0.8:5.319e+05]
  set format y '10^{%T}'
  set ytics 10
  set ylabel 'CPU / fastest' offset 0.5,0
  set xlabel 'CPU of the fastest [ms]' offset 0,0.3
  set xtics ('0.00023' 1, '0.033' 15, '0.14' 29, '0.56' 43, '2.9' 57)
  set label 'diamonds: auto; crosses: not solved; rings: not decided; '."measured CPU of this machine; rings: the limit of CPU came first" at screen 0.04,0.012 left font ',12' noenhanced
  plot 2 with filledcurves y1=0.8 fc rgb '#e4e4e4', \
      'solvers_profile_2d.dat' index 5 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#0072b2', \
      'solvers_profile_2d.dat' index 6 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 1 lc rgb '#0072b2', \
      'solvers_profile_2d.dat' index 9 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#56b4e9', \
      'solvers_profile_2d.dat' index 13 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#e69f00', \
      'solvers_profile_2d.dat' index 17 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#009e73', \
      'solvers_profile_2d.dat' index 19 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#009e73', \
      'solvers_profile_2d.dat' index 21 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#d55e00', \
      'solvers_profile_2d.dat' index 23 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#d55e00', \
      'solvers_profile_2d.dat' index 25 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#cc79a7', \
      'solvers_profile_2d.dat' index 27 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#cc79a7', \
      'solvers_profile_2d.dat' index 29 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 2 lc rgb '#b00020', \
      'solvers_profile_2d.dat' index 33 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 3 lc rgb '#7f0000', \
      'solvers_profile_2d.dat' index 49 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 3 lc rgb '#b00020', \
      'solvers_profile_2d.dat' index 51 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 3 lc rgb '#b00020', \
      'solvers_profile_2d.dat' index 53 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 4 lc rgb '#7f0000', \
      'solvers_profile_2d.dat' index 54 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 4 lc rgb '#7f0000', \
      'solvers_profile_2d.dat' index 55 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 4 lc rgb '#7f0000', \
      'solvers_profile_2d.dat' index 1 using 1:2 with points pt 13 ps 1.6 lw 4 dt 1 lc rgb '#000000'
  set lmargin at screen 0.38333
  set rmargin at screen 0.64867
  set bmargin at screen 0.575
  set tmargin at screen 0.92
  unset label
  unset arrow
  unset title
  set title '{/:Bold residual 1e-8}' offset 0,-0.6
  set logscale x
  unset logscale y
  set xrange [1:1000]
  set yrange [0:1.02]
  set format x '%g'
  set format y '%g'
  set xtics 10
  set ytics 0.2
  set xlabel 'CPU / fastest, at most' offset 0,0.5
  set ylabel '' offset 1,0
  set arrow from screen 0.3833,0.5170 to screen 0.4033,0.5170 nohead lw 4 dt 1 lc rgb '#000000'
  set label "auto".'  59/59' at screen 0.4083,0.5170 left font ',10' noenhanced
  set arrow from screen 0.3833,0.5010 to screen 0.4033,0.5010 nohead lw 1.8 dt 1 lc rgb '#0072b2'
  set label "newton".'  57/59' at screen 0.4083,0.5010 left font ',10' noenhanced
  set arrow from screen 0.3833,0.4850 to screen 0.4033,0.4850 nohead lw 1.8 dt 1 lc rgb '#56b4e9'
  set label "nlgs+anderson".'  58/59' at screen 0.4083,0.4850 left font ',10' noenhanced
  set arrow from screen 0.3833,0.4690 to screen 0.4033,0.4690 nohead lw 1.8 dt 1 lc rgb '#e69f00'
  set label "nlgs".'  57/59' at screen 0.4083,0.4690 left font ',10' noenhanced
  set arrow from screen 0.3833,0.4530 to screen 0.4033,0.4530 nohead lw 1.8 dt 1 lc rgb '#009e73'
  set label "admm".'  58/59' at screen 0.4083,0.4530 left font ',10' noenhanced
  set arrow from screen 0.3833,0.4370 to screen 0.4033,0.4370 nohead lw 1.8 dt 1 lc rgb '#d55e00'
  set label "augmented-lagrangian".'  58/59' at screen 0.4083,0.4370 left font ',10' noenhanced
  set arrow from screen 0.3833,0.4210 to screen 0.4033,0.4210 nohead lw 1.8 dt 1 lc rgb '#cc79a7'
  set label "lemke".'  53/57' at screen 0.4083,0.4210 left font ',10' noenhanced
  set arrow from screen 0.5240,0.5170 to screen 0.5440,0.5170 nohead lw 1.8 dt 2 lc rgb '#b00020'
  set label "best of Siconos".'  56/58' at screen 0.5490,0.5170 left font ',10' noenhanced
  set arrow from screen 0.5240,0.5010 to screen 0.5440,0.5010 nohead lw 1.8 dt 3 lc rgb '#7f0000'
  set label "Siconos NSGS".'  56/58' at screen 0.5490,0.5010 left font ',10' noenhanced
  set arrow from screen 0.5240,0.4850 to screen 0.5440,0.4850 nohead lw 1.8 dt 4 lc rgb '#ff5a7a'
  set label "Siconos NSN".'  3D only' at screen 0.5490,0.4850 left font ',10' noenhanced
  set arrow from screen 0.5240,0.4690 to screen 0.5440,0.4690 nohead lw 1.8 dt 5 lc rgb '#a0522d'
  set label "Siconos ADMM".'  3D only' at screen 0.5490,0.4690 left font ',10' noenhanced
  set arrow from screen 0.5240,0.4530 to screen 0.5440,0.4530 nohead lw 1.8 dt 2 lc rgb '#c71585'
  set label "Siconos PROX".'  3D only' at screen 0.5490,0.4530 left font ',10' noenhanced
  set arrow from screen 0.5240,0.4370 to screen 0.5440,0.4370 nohead lw 1.8 dt 3 lc rgb '#b00020'
  set label "Siconos CPG".'  43/57' at screen 0.5490,0.4370 left font ',10' noenhanced
  set arrow from screen 0.5240,0.4210 to screen 0.5440,0.4210 nohead lw 1.8 dt 4 lc rgb '#7f0000'
  set label "Siconos Lemke".'  39/57' at screen 0.5490,0.4210 left font ',10' noenhanced
  plot -1 with lines, \
       'solvers_profile_2d.dat' index 60 using 1:2 with steps lw 1.8 dt 1 lc rgb '#0072b2', \
       'solvers_profile_2d.dat' index 64 using 1:2 with steps lw 1.8 dt 1 lc rgb '#56b4e9', \
       'solvers_profile_2d.dat' index 68 using 1:2 with steps lw 1.8 dt 1 lc rgb '#e69f00', \
       'solvers_profile_2d.dat' index 72 using 1:2 with steps lw 1.8 dt 1 lc rgb '#009e73', \
       'solvers_profile_2d.dat' index 76 using 1:2 with steps lw 1.8 dt 1 lc rgb '#d55e00', \
       'solvers_profile_2d.dat' index 80 using 1:2 with steps lw 1.8 dt 1 lc rgb '#cc79a7', \
       'solvers_profile_2d.dat' index 84 using 1:2 with steps lw 1.8 dt 2 lc rgb '#b00020', \
       'solvers_profile_2d.dat' index 88 using 1:2 with steps lw 1.8 dt 3 lc rgb '#7f0000', \
       'solvers_profile_2d.dat' index 104 using 1:2 with steps lw 1.8 dt 3 lc rgb '#b00020', \
       'solvers_profile_2d.dat' index 108 using 1:2 with steps lw 1.8 dt 4 lc rgb '#7f0000', \
       'solvers_profile_2d.dat' index 56 using 1:2 with steps lw 4 dt 1 lc rgb '#000000'
  set lmargin at screen 0.38333
  set rmargin at screen 0.64867
  set bmargin at screen 0.075
  set tmargin at screen 0.36
  unset label
  unset arrow
  unset title
  set title 'each problem, from quick to slow' offset 0,-0.6 font ',12'
  unset logscale x
  set logscale y
  set xrange [0:60]
  set yrange [0.8:4.217e+05]
  set format y '10^{%T}'
  set ytics 10
  set ylabel '' offset 0.5,0
  set xlabel 'CPU of the fastest [ms]' offset 0,0.3
  set xtics ('0.00021' 1, '0.041' 15, '0.13' 29, '0.63' 43, '6.1' 57)
  plot 2 with filledcurves y1=0.8 fc rgb '#e4e4e4', \
      'solvers_profile_2d.dat' index 61 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#0072b2', \
      'solvers_profile_2d.dat' index 62 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 1 lc rgb '#0072b2', \
      'solvers_profile_2d.dat' index 65 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#56b4e9', \
      'solvers_profile_2d.dat' index 67 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#56b4e9', \
      'solvers_profile_2d.dat' index 69 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#e69f00', \
      'solvers_profile_2d.dat' index 71 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#e69f00', \
      'solvers_profile_2d.dat' index 73 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#009e73', \
      'solvers_profile_2d.dat' index 75 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#009e73', \
      'solvers_profile_2d.dat' index 77 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#d55e00', \
      'solvers_profile_2d.dat' index 79 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#d55e00', \
      'solvers_profile_2d.dat' index 81 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#cc79a7', \
      'solvers_profile_2d.dat' index 83 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#cc79a7', \
      'solvers_profile_2d.dat' index 85 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 2 lc rgb '#b00020', \
      'solvers_profile_2d.dat' index 87 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 2 lc rgb '#b00020', \
      'solvers_profile_2d.dat' index 89 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 3 lc rgb '#7f0000', \
      'solvers_profile_2d.dat' index 91 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 3 lc rgb '#7f0000', \
      'solvers_profile_2d.dat' index 105 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 3 lc rgb '#b00020', \
      'solvers_profile_2d.dat' index 106 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 3 lc rgb '#b00020', \
      'solvers_profile_2d.dat' index 107 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 3 lc rgb '#b00020', \
      'solvers_profile_2d.dat' index 109 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 4 lc rgb '#7f0000', \
      'solvers_profile_2d.dat' index 110 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 4 lc rgb '#7f0000', \
      'solvers_profile_2d.dat' index 111 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 4 lc rgb '#7f0000', \
      'solvers_profile_2d.dat' index 57 using 1:2 with points pt 13 ps 1.6 lw 4 dt 1 lc rgb '#000000'
  set lmargin at screen 0.71667
  set rmargin at screen 0.982
  set bmargin at screen 0.575
  set tmargin at screen 0.92
  unset label
  unset arrow
  unset title
  set title '{/:Bold residual 1e-12}' offset 0,-0.6
  set logscale x
  unset logscale y
  set xrange [1:1000]
  set yrange [0:1.02]
  set format x '%g'
  set format y '%g'
  set xtics 10
  set ytics 0.2
  set xlabel 'CPU / fastest, at most' offset 0,0.5
  set ylabel '' offset 1,0
  set arrow from screen 0.7167,0.5170 to screen 0.7367,0.5170 nohead lw 4 dt 1 lc rgb '#000000'
  set label "auto".'  59/59' at screen 0.7417,0.5170 left font ',10' noenhanced
  set arrow from screen 0.7167,0.5010 to screen 0.7367,0.5010 nohead lw 1.8 dt 1 lc rgb '#0072b2'
  set label "newton".'  56/59' at screen 0.7417,0.5010 left font ',10' noenhanced
  set arrow from screen 0.7167,0.4850 to screen 0.7367,0.4850 nohead lw 1.8 dt 1 lc rgb '#56b4e9'
  set label "nlgs+anderson".'  58/59' at screen 0.7417,0.4850 left font ',10' noenhanced
  set arrow from screen 0.7167,0.4690 to screen 0.7367,0.4690 nohead lw 1.8 dt 1 lc rgb '#e69f00'
  set label "nlgs".'  57/59' at screen 0.7417,0.4690 left font ',10' noenhanced
  set arrow from screen 0.7167,0.4530 to screen 0.7367,0.4530 nohead lw 1.8 dt 1 lc rgb '#009e73'
  set label "admm".'  57/59' at screen 0.7417,0.4530 left font ',10' noenhanced
  set arrow from screen 0.7167,0.4370 to screen 0.7367,0.4370 nohead lw 1.8 dt 1 lc rgb '#d55e00'
  set label "augmented-lagrangian".'  58/59' at screen 0.7417,0.4370 left font ',10' noenhanced
  set arrow from screen 0.7167,0.4210 to screen 0.7367,0.4210 nohead lw 1.8 dt 1 lc rgb '#cc79a7'
  set label "lemke".'  53/57' at screen 0.7417,0.4210 left font ',10' noenhanced
  set arrow from screen 0.8573,0.5170 to screen 0.8773,0.5170 nohead lw 1.8 dt 2 lc rgb '#b00020'
  set label "best of Siconos".'  56/58' at screen 0.8823,0.5170 left font ',10' noenhanced
  set arrow from screen 0.8573,0.5010 to screen 0.8773,0.5010 nohead lw 1.8 dt 3 lc rgb '#7f0000'
  set label "Siconos NSGS".'  56/58' at screen 0.8823,0.5010 left font ',10' noenhanced
  set arrow from screen 0.8573,0.4850 to screen 0.8773,0.4850 nohead lw 1.8 dt 4 lc rgb '#ff5a7a'
  set label "Siconos NSN".'  3D only' at screen 0.8823,0.4850 left font ',10' noenhanced
  set arrow from screen 0.8573,0.4690 to screen 0.8773,0.4690 nohead lw 1.8 dt 5 lc rgb '#a0522d'
  set label "Siconos ADMM".'  3D only' at screen 0.8823,0.4690 left font ',10' noenhanced
  set arrow from screen 0.8573,0.4530 to screen 0.8773,0.4530 nohead lw 1.8 dt 2 lc rgb '#c71585'
  set label "Siconos PROX".'  3D only' at screen 0.8823,0.4530 left font ',10' noenhanced
  set arrow from screen 0.8573,0.4370 to screen 0.8773,0.4370 nohead lw 1.8 dt 3 lc rgb '#b00020'
  set label "Siconos CPG".'  42/57' at screen 0.8823,0.4370 left font ',10' noenhanced
  set arrow from screen 0.8573,0.4210 to screen 0.8773,0.4210 nohead lw 1.8 dt 4 lc rgb '#7f0000'
  set label "Siconos Lemke".'  39/57' at screen 0.8823,0.4210 left font ',10' noenhanced
  plot -1 with lines, \
       'solvers_profile_2d.dat' index 116 using 1:2 with steps lw 1.8 dt 1 lc rgb '#0072b2', \
       'solvers_profile_2d.dat' index 120 using 1:2 with steps lw 1.8 dt 1 lc rgb '#56b4e9', \
       'solvers_profile_2d.dat' index 124 using 1:2 with steps lw 1.8 dt 1 lc rgb '#e69f00', \
       'solvers_profile_2d.dat' index 128 using 1:2 with steps lw 1.8 dt 1 lc rgb '#009e73', \
       'solvers_profile_2d.dat' index 132 using 1:2 with steps lw 1.8 dt 1 lc rgb '#d55e00', \
       'solvers_profile_2d.dat' index 136 using 1:2 with steps lw 1.8 dt 1 lc rgb '#cc79a7', \
       'solvers_profile_2d.dat' index 140 using 1:2 with steps lw 1.8 dt 2 lc rgb '#b00020', \
       'solvers_profile_2d.dat' index 144 using 1:2 with steps lw 1.8 dt 3 lc rgb '#7f0000', \
       'solvers_profile_2d.dat' index 160 using 1:2 with steps lw 1.8 dt 3 lc rgb '#b00020', \
       'solvers_profile_2d.dat' index 164 using 1:2 with steps lw 1.8 dt 4 lc rgb '#7f0000', \
       'solvers_profile_2d.dat' index 112 using 1:2 with steps lw 4 dt 1 lc rgb '#000000'
  set lmargin at screen 0.71667
  set rmargin at screen 0.982
  set bmargin at screen 0.075
  set tmargin at screen 0.36
  unset label
  unset arrow
  unset title
  set title 'each problem, from quick to slow' offset 0,-0.6 font ',12'
  unset logscale x
  set logscale y
  set xrange [0:60]
  set yrange [0.8:3.676e+05]
  set format y '10^{%T}'
  set ytics 10
  set ylabel '' offset 0.5,0
  set xlabel 'CPU of the fastest [ms]' offset 0,0.3
  set xtics ('0.00023' 1, '0.047' 15, '0.14' 29, '0.63' 43, '7.8' 57)
  plot 2 with filledcurves y1=0.8 fc rgb '#e4e4e4', \
      'solvers_profile_2d.dat' index 117 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#0072b2', \
      'solvers_profile_2d.dat' index 118 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 1 lc rgb '#0072b2', \
      'solvers_profile_2d.dat' index 121 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#56b4e9', \
      'solvers_profile_2d.dat' index 123 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#56b4e9', \
      'solvers_profile_2d.dat' index 125 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#e69f00', \
      'solvers_profile_2d.dat' index 127 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#e69f00', \
      'solvers_profile_2d.dat' index 129 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#009e73', \
      'solvers_profile_2d.dat' index 131 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#009e73', \
      'solvers_profile_2d.dat' index 133 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#d55e00', \
      'solvers_profile_2d.dat' index 135 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#d55e00', \
      'solvers_profile_2d.dat' index 137 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#cc79a7', \
      'solvers_profile_2d.dat' index 139 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#cc79a7', \
      'solvers_profile_2d.dat' index 141 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 2 lc rgb '#b00020', \
      'solvers_profile_2d.dat' index 143 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 2 lc rgb '#b00020', \
      'solvers_profile_2d.dat' index 145 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 3 lc rgb '#7f0000', \
      'solvers_profile_2d.dat' index 147 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 3 lc rgb '#7f0000', \
      'solvers_profile_2d.dat' index 161 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 3 lc rgb '#b00020', \
      'solvers_profile_2d.dat' index 163 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 3 lc rgb '#b00020', \
      'solvers_profile_2d.dat' index 165 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 4 lc rgb '#7f0000', \
      'solvers_profile_2d.dat' index 166 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 4 lc rgb '#7f0000', \
      'solvers_profile_2d.dat' index 167 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 4 lc rgb '#7f0000', \
      'solvers_profile_2d.dat' index 113 using 1:2 with points pt 13 ps 1.6 lw 4 dt 1 lc rgb '#000000'

  unset multiplot
  unset output
}
