set datafile missing 'NaN'
set key off
set grid lc rgb '#d8d8d8'
set encoding utf8
do for [type in 'png svg'] {
  if (type eq 'png') { set terminal pngcairo size 1800,1100 font ',13' }
  if (type eq 'svg') { set terminal svg size 1800,1100 font ',13' background 'white' }
  set output 'solvers_profile_3d.'.type
  set multiplot title "59 scenes in 3D: delassus, and dashed Siconos" font ',17' noenhanced
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
  set label "newton".'  58/59' at screen 0.0750,0.5010 left font ',10' noenhanced
  set arrow from screen 0.0500,0.4850 to screen 0.0700,0.4850 nohead lw 1.8 dt 1 lc rgb '#56b4e9'
  set label "nlgs+anderson".'  59/59' at screen 0.0750,0.4850 left font ',10' noenhanced
  set arrow from screen 0.0500,0.4690 to screen 0.0700,0.4690 nohead lw 1.8 dt 1 lc rgb '#e69f00'
  set label "nlgs".'  58/59' at screen 0.0750,0.4690 left font ',10' noenhanced
  set arrow from screen 0.0500,0.4530 to screen 0.0700,0.4530 nohead lw 1.8 dt 1 lc rgb '#009e73'
  set label "admm".'  59/59' at screen 0.0750,0.4530 left font ',10' noenhanced
  set arrow from screen 0.0500,0.4370 to screen 0.0700,0.4370 nohead lw 1.8 dt 1 lc rgb '#d55e00'
  set label "augmented-lagrangian".'  59/59' at screen 0.0750,0.4370 left font ',10' noenhanced
  set arrow from screen 0.0500,0.4210 to screen 0.0700,0.4210 nohead lw 1.8 dt 1 lc rgb '#cc79a7'
  set label "lemke".'  39/39' at screen 0.0750,0.4210 left font ',10' noenhanced
  set arrow from screen 0.1906,0.5170 to screen 0.2106,0.5170 nohead lw 1.8 dt 2 lc rgb '#b00020'
  set label "best of Siconos".'  59/59' at screen 0.2156,0.5170 left font ',10' noenhanced
  set arrow from screen 0.1906,0.5010 to screen 0.2106,0.5010 nohead lw 1.8 dt 3 lc rgb '#7f0000'
  set label "Siconos NSGS".'  57/59' at screen 0.2156,0.5010 left font ',10' noenhanced
  set arrow from screen 0.1906,0.4850 to screen 0.2106,0.4850 nohead lw 1.8 dt 4 lc rgb '#ff5a7a'
  set label "Siconos NSN".'  53/59' at screen 0.2156,0.4850 left font ',10' noenhanced
  set arrow from screen 0.1906,0.4690 to screen 0.2106,0.4690 nohead lw 1.8 dt 5 lc rgb '#a0522d'
  set label "Siconos ADMM".'  53/59' at screen 0.2156,0.4690 left font ',10' noenhanced
  set arrow from screen 0.1906,0.4530 to screen 0.2106,0.4530 nohead lw 1.8 dt 2 lc rgb '#c71585'
  set label "Siconos PROX".'  49/51' at screen 0.2156,0.4530 left font ',10' noenhanced
  set arrow from screen 0.1906,0.4370 to screen 0.2106,0.4370 nohead lw 1.8 dt 3 lc rgb '#b00020'
  set label "Siconos CPG".'  2D only' at screen 0.2156,0.4370 left font ',10' noenhanced
  set arrow from screen 0.1906,0.4210 to screen 0.2106,0.4210 nohead lw 1.8 dt 4 lc rgb '#7f0000'
  set label "Siconos Lemke".'  2D only' at screen 0.2156,0.4210 left font ',10' noenhanced
  plot -1 with lines, \
       'solvers_profile_3d.dat' index 4 using 1:2 with steps lw 1.8 dt 1 lc rgb '#0072b2', \
       'solvers_profile_3d.dat' index 8 using 1:2 with steps lw 1.8 dt 1 lc rgb '#56b4e9', \
       'solvers_profile_3d.dat' index 12 using 1:2 with steps lw 1.8 dt 1 lc rgb '#e69f00', \
       'solvers_profile_3d.dat' index 16 using 1:2 with steps lw 1.8 dt 1 lc rgb '#009e73', \
       'solvers_profile_3d.dat' index 20 using 1:2 with steps lw 1.8 dt 1 lc rgb '#d55e00', \
       'solvers_profile_3d.dat' index 24 using 1:2 with steps lw 1.8 dt 1 lc rgb '#cc79a7', \
       'solvers_profile_3d.dat' index 28 using 1:2 with steps lw 1.8 dt 2 lc rgb '#b00020', \
       'solvers_profile_3d.dat' index 32 using 1:2 with steps lw 1.8 dt 3 lc rgb '#7f0000', \
       'solvers_profile_3d.dat' index 36 using 1:2 with steps lw 1.8 dt 4 lc rgb '#ff5a7a', \
       'solvers_profile_3d.dat' index 40 using 1:2 with steps lw 1.8 dt 5 lc rgb '#a0522d', \
       'solvers_profile_3d.dat' index 44 using 1:2 with steps lw 1.8 dt 2 lc rgb '#c71585', \
       'solvers_profile_3d.dat' index 0 using 1:2 with steps lw 4 dt 1 lc rgb '#000000'
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
  set yrange [0.8:2.512e+06]
  set format y '10^{%T}'
  set ytics 10
  set ylabel 'CPU / fastest' offset 0.5,0
  set xlabel 'CPU of the fastest [ms]' offset 0,0.3
  set xtics ('2.1e-05' 1, '0.0077' 15, '0.08' 29, '0.92' 43, '7.6' 57)
  set label 'diamonds: auto; crosses: not solved; rings: not decided; '."measured CPU of this machine; rings: the limit of CPU came first" at screen 0.04,0.012 left font ',12' noenhanced
  plot 2 with filledcurves y1=0.8 fc rgb '#e4e4e4', \
      'solvers_profile_3d.dat' index 5 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#0072b2', \
      'solvers_profile_3d.dat' index 6 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 1 lc rgb '#0072b2', \
      'solvers_profile_3d.dat' index 9 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#56b4e9', \
      'solvers_profile_3d.dat' index 13 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#e69f00', \
      'solvers_profile_3d.dat' index 15 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#e69f00', \
      'solvers_profile_3d.dat' index 17 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#009e73', \
      'solvers_profile_3d.dat' index 21 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#d55e00', \
      'solvers_profile_3d.dat' index 25 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#cc79a7', \
      'solvers_profile_3d.dat' index 29 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 2 lc rgb '#b00020', \
      'solvers_profile_3d.dat' index 33 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 3 lc rgb '#7f0000', \
      'solvers_profile_3d.dat' index 35 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 3 lc rgb '#7f0000', \
      'solvers_profile_3d.dat' index 37 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 4 lc rgb '#ff5a7a', \
      'solvers_profile_3d.dat' index 39 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 4 lc rgb '#ff5a7a', \
      'solvers_profile_3d.dat' index 41 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 5 lc rgb '#a0522d', \
      'solvers_profile_3d.dat' index 42 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 5 lc rgb '#a0522d', \
      'solvers_profile_3d.dat' index 43 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 5 lc rgb '#a0522d', \
      'solvers_profile_3d.dat' index 45 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 2 lc rgb '#c71585', \
      'solvers_profile_3d.dat' index 46 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 2 lc rgb '#c71585', \
      'solvers_profile_3d.dat' index 1 using 1:2 with points pt 13 ps 1.6 lw 4 dt 1 lc rgb '#000000'
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
  set label "newton".'  58/59' at screen 0.4083,0.5010 left font ',10' noenhanced
  set arrow from screen 0.3833,0.4850 to screen 0.4033,0.4850 nohead lw 1.8 dt 1 lc rgb '#56b4e9'
  set label "nlgs+anderson".'  59/59' at screen 0.4083,0.4850 left font ',10' noenhanced
  set arrow from screen 0.3833,0.4690 to screen 0.4033,0.4690 nohead lw 1.8 dt 1 lc rgb '#e69f00'
  set label "nlgs".'  56/59' at screen 0.4083,0.4690 left font ',10' noenhanced
  set arrow from screen 0.3833,0.4530 to screen 0.4033,0.4530 nohead lw 1.8 dt 1 lc rgb '#009e73'
  set label "admm".'  58/59' at screen 0.4083,0.4530 left font ',10' noenhanced
  set arrow from screen 0.3833,0.4370 to screen 0.4033,0.4370 nohead lw 1.8 dt 1 lc rgb '#d55e00'
  set label "augmented-lagrangian".'  59/59' at screen 0.4083,0.4370 left font ',10' noenhanced
  set arrow from screen 0.3833,0.4210 to screen 0.4033,0.4210 nohead lw 1.8 dt 1 lc rgb '#cc79a7'
  set label "lemke".'  39/39' at screen 0.4083,0.4210 left font ',10' noenhanced
  set arrow from screen 0.5240,0.5170 to screen 0.5440,0.5170 nohead lw 1.8 dt 2 lc rgb '#b00020'
  set label "best of Siconos".'  59/59' at screen 0.5490,0.5170 left font ',10' noenhanced
  set arrow from screen 0.5240,0.5010 to screen 0.5440,0.5010 nohead lw 1.8 dt 3 lc rgb '#7f0000'
  set label "Siconos NSGS".'  53/59' at screen 0.5490,0.5010 left font ',10' noenhanced
  set arrow from screen 0.5240,0.4850 to screen 0.5440,0.4850 nohead lw 1.8 dt 4 lc rgb '#ff5a7a'
  set label "Siconos NSN".'  51/59' at screen 0.5490,0.4850 left font ',10' noenhanced
  set arrow from screen 0.5240,0.4690 to screen 0.5440,0.4690 nohead lw 1.8 dt 5 lc rgb '#a0522d'
  set label "Siconos ADMM".'  50/59' at screen 0.5490,0.4690 left font ',10' noenhanced
  set arrow from screen 0.5240,0.4530 to screen 0.5440,0.4530 nohead lw 1.8 dt 2 lc rgb '#c71585'
  set label "Siconos PROX".'  49/51' at screen 0.5490,0.4530 left font ',10' noenhanced
  set arrow from screen 0.5240,0.4370 to screen 0.5440,0.4370 nohead lw 1.8 dt 3 lc rgb '#b00020'
  set label "Siconos CPG".'  2D only' at screen 0.5490,0.4370 left font ',10' noenhanced
  set arrow from screen 0.5240,0.4210 to screen 0.5440,0.4210 nohead lw 1.8 dt 4 lc rgb '#7f0000'
  set label "Siconos Lemke".'  2D only' at screen 0.5490,0.4210 left font ',10' noenhanced
  plot -1 with lines, \
       'solvers_profile_3d.dat' index 60 using 1:2 with steps lw 1.8 dt 1 lc rgb '#0072b2', \
       'solvers_profile_3d.dat' index 64 using 1:2 with steps lw 1.8 dt 1 lc rgb '#56b4e9', \
       'solvers_profile_3d.dat' index 68 using 1:2 with steps lw 1.8 dt 1 lc rgb '#e69f00', \
       'solvers_profile_3d.dat' index 72 using 1:2 with steps lw 1.8 dt 1 lc rgb '#009e73', \
       'solvers_profile_3d.dat' index 76 using 1:2 with steps lw 1.8 dt 1 lc rgb '#d55e00', \
       'solvers_profile_3d.dat' index 80 using 1:2 with steps lw 1.8 dt 1 lc rgb '#cc79a7', \
       'solvers_profile_3d.dat' index 84 using 1:2 with steps lw 1.8 dt 2 lc rgb '#b00020', \
       'solvers_profile_3d.dat' index 88 using 1:2 with steps lw 1.8 dt 3 lc rgb '#7f0000', \
       'solvers_profile_3d.dat' index 92 using 1:2 with steps lw 1.8 dt 4 lc rgb '#ff5a7a', \
       'solvers_profile_3d.dat' index 96 using 1:2 with steps lw 1.8 dt 5 lc rgb '#a0522d', \
       'solvers_profile_3d.dat' index 100 using 1:2 with steps lw 1.8 dt 2 lc rgb '#c71585', \
       'solvers_profile_3d.dat' index 56 using 1:2 with steps lw 4 dt 1 lc rgb '#000000'
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
  set yrange [0.8:2.512e+06]
  set format y '10^{%T}'
  set ytics 10
  set ylabel '' offset 0.5,0
  set xlabel 'CPU of the fastest [ms]' offset 0,0.3
  set xtics ('2.1e-05' 1, '0.0051' 15, '0.091' 29, '1.4' 43, '10' 57)
  plot 2 with filledcurves y1=0.8 fc rgb '#e4e4e4', \
      'solvers_profile_3d.dat' index 61 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#0072b2', \
      'solvers_profile_3d.dat' index 62 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 1 lc rgb '#0072b2', \
      'solvers_profile_3d.dat' index 65 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#56b4e9', \
      'solvers_profile_3d.dat' index 69 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#e69f00', \
      'solvers_profile_3d.dat' index 71 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#e69f00', \
      'solvers_profile_3d.dat' index 73 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#009e73', \
      'solvers_profile_3d.dat' index 75 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#009e73', \
      'solvers_profile_3d.dat' index 77 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#d55e00', \
      'solvers_profile_3d.dat' index 81 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#cc79a7', \
      'solvers_profile_3d.dat' index 85 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 2 lc rgb '#b00020', \
      'solvers_profile_3d.dat' index 89 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 3 lc rgb '#7f0000', \
      'solvers_profile_3d.dat' index 91 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 3 lc rgb '#7f0000', \
      'solvers_profile_3d.dat' index 93 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 4 lc rgb '#ff5a7a', \
      'solvers_profile_3d.dat' index 95 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 4 lc rgb '#ff5a7a', \
      'solvers_profile_3d.dat' index 97 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 5 lc rgb '#a0522d', \
      'solvers_profile_3d.dat' index 99 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 5 lc rgb '#a0522d', \
      'solvers_profile_3d.dat' index 101 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 2 lc rgb '#c71585', \
      'solvers_profile_3d.dat' index 102 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 2 lc rgb '#c71585', \
      'solvers_profile_3d.dat' index 57 using 1:2 with points pt 13 ps 1.6 lw 4 dt 1 lc rgb '#000000'
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
  set label "newton".'  57/59' at screen 0.7417,0.5010 left font ',10' noenhanced
  set arrow from screen 0.7167,0.4850 to screen 0.7367,0.4850 nohead lw 1.8 dt 1 lc rgb '#56b4e9'
  set label "nlgs+anderson".'  59/59' at screen 0.7417,0.4850 left font ',10' noenhanced
  set arrow from screen 0.7167,0.4690 to screen 0.7367,0.4690 nohead lw 1.8 dt 1 lc rgb '#e69f00'
  set label "nlgs".'  55/59' at screen 0.7417,0.4690 left font ',10' noenhanced
  set arrow from screen 0.7167,0.4530 to screen 0.7367,0.4530 nohead lw 1.8 dt 1 lc rgb '#009e73'
  set label "admm".'  57/59' at screen 0.7417,0.4530 left font ',10' noenhanced
  set arrow from screen 0.7167,0.4370 to screen 0.7367,0.4370 nohead lw 1.8 dt 1 lc rgb '#d55e00'
  set label "augmented-lagrangian".'  59/59' at screen 0.7417,0.4370 left font ',10' noenhanced
  set arrow from screen 0.7167,0.4210 to screen 0.7367,0.4210 nohead lw 1.8 dt 1 lc rgb '#cc79a7'
  set label "lemke".'  39/39' at screen 0.7417,0.4210 left font ',10' noenhanced
  set arrow from screen 0.8573,0.5170 to screen 0.8773,0.5170 nohead lw 1.8 dt 2 lc rgb '#b00020'
  set label "best of Siconos".'  59/59' at screen 0.8823,0.5170 left font ',10' noenhanced
  set arrow from screen 0.8573,0.5010 to screen 0.8773,0.5010 nohead lw 1.8 dt 3 lc rgb '#7f0000'
  set label "Siconos NSGS".'  51/59' at screen 0.8823,0.5010 left font ',10' noenhanced
  set arrow from screen 0.8573,0.4850 to screen 0.8773,0.4850 nohead lw 1.8 dt 4 lc rgb '#ff5a7a'
  set label "Siconos NSN".'  38/59' at screen 0.8823,0.4850 left font ',10' noenhanced
  set arrow from screen 0.8573,0.4690 to screen 0.8773,0.4690 nohead lw 1.8 dt 5 lc rgb '#a0522d'
  set label "Siconos ADMM".'  42/59' at screen 0.8823,0.4690 left font ',10' noenhanced
  set arrow from screen 0.8573,0.4530 to screen 0.8773,0.4530 nohead lw 1.8 dt 2 lc rgb '#c71585'
  set label "Siconos PROX".'  31/51' at screen 0.8823,0.4530 left font ',10' noenhanced
  set arrow from screen 0.8573,0.4370 to screen 0.8773,0.4370 nohead lw 1.8 dt 3 lc rgb '#b00020'
  set label "Siconos CPG".'  2D only' at screen 0.8823,0.4370 left font ',10' noenhanced
  set arrow from screen 0.8573,0.4210 to screen 0.8773,0.4210 nohead lw 1.8 dt 4 lc rgb '#7f0000'
  set label "Siconos Lemke".'  2D only' at screen 0.8823,0.4210 left font ',10' noenhanced
  plot -1 with lines, \
       'solvers_profile_3d.dat' index 116 using 1:2 with steps lw 1.8 dt 1 lc rgb '#0072b2', \
       'solvers_profile_3d.dat' index 120 using 1:2 with steps lw 1.8 dt 1 lc rgb '#56b4e9', \
       'solvers_profile_3d.dat' index 124 using 1:2 with steps lw 1.8 dt 1 lc rgb '#e69f00', \
       'solvers_profile_3d.dat' index 128 using 1:2 with steps lw 1.8 dt 1 lc rgb '#009e73', \
       'solvers_profile_3d.dat' index 132 using 1:2 with steps lw 1.8 dt 1 lc rgb '#d55e00', \
       'solvers_profile_3d.dat' index 136 using 1:2 with steps lw 1.8 dt 1 lc rgb '#cc79a7', \
       'solvers_profile_3d.dat' index 140 using 1:2 with steps lw 1.8 dt 2 lc rgb '#b00020', \
       'solvers_profile_3d.dat' index 144 using 1:2 with steps lw 1.8 dt 3 lc rgb '#7f0000', \
       'solvers_profile_3d.dat' index 148 using 1:2 with steps lw 1.8 dt 4 lc rgb '#ff5a7a', \
       'solvers_profile_3d.dat' index 152 using 1:2 with steps lw 1.8 dt 5 lc rgb '#a0522d', \
       'solvers_profile_3d.dat' index 156 using 1:2 with steps lw 1.8 dt 2 lc rgb '#c71585', \
       'solvers_profile_3d.dat' index 112 using 1:2 with steps lw 4 dt 1 lc rgb '#000000'
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
  set yrange [0.8:2.512e+06]
  set format y '10^{%T}'
  set ytics 10
  set ylabel '' offset 0.5,0
  set xlabel 'CPU of the fastest [ms]' offset 0,0.3
  set xtics ('2.1e-05' 1, '0.0065' 15, '0.1' 29, '1.2' 43, '14' 57)
  plot 2 with filledcurves y1=0.8 fc rgb '#e4e4e4', \
      'solvers_profile_3d.dat' index 117 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#0072b2', \
      'solvers_profile_3d.dat' index 118 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 1 lc rgb '#0072b2', \
      'solvers_profile_3d.dat' index 119 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#0072b2', \
      'solvers_profile_3d.dat' index 121 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#56b4e9', \
      'solvers_profile_3d.dat' index 125 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#e69f00', \
      'solvers_profile_3d.dat' index 127 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#e69f00', \
      'solvers_profile_3d.dat' index 129 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#009e73', \
      'solvers_profile_3d.dat' index 131 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 1 lc rgb '#009e73', \
      'solvers_profile_3d.dat' index 133 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#d55e00', \
      'solvers_profile_3d.dat' index 137 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 1 lc rgb '#cc79a7', \
      'solvers_profile_3d.dat' index 141 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 2 lc rgb '#b00020', \
      'solvers_profile_3d.dat' index 145 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 3 lc rgb '#7f0000', \
      'solvers_profile_3d.dat' index 146 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 3 lc rgb '#7f0000', \
      'solvers_profile_3d.dat' index 147 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 3 lc rgb '#7f0000', \
      'solvers_profile_3d.dat' index 149 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 4 lc rgb '#ff5a7a', \
      'solvers_profile_3d.dat' index 150 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 4 lc rgb '#ff5a7a', \
      'solvers_profile_3d.dat' index 151 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 4 lc rgb '#ff5a7a', \
      'solvers_profile_3d.dat' index 153 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 5 lc rgb '#a0522d', \
      'solvers_profile_3d.dat' index 154 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 5 lc rgb '#a0522d', \
      'solvers_profile_3d.dat' index 155 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 5 lc rgb '#a0522d', \
      'solvers_profile_3d.dat' index 157 using 1:2 with points pt 7 ps 0.65 lw 1.8 dt 2 lc rgb '#c71585', \
      'solvers_profile_3d.dat' index 158 using 1:2 with points pt 2 ps 0.55 lw 1.8 dt 2 lc rgb '#c71585', \
      'solvers_profile_3d.dat' index 159 using 1:2 with points pt 6 ps 0.7 lw 1.8 dt 2 lc rgb '#c71585', \
      'solvers_profile_3d.dat' index 113 using 1:2 with points pt 13 ps 1.6 lw 4 dt 1 lc rgb '#000000'

  unset multiplot
  unset output
}
