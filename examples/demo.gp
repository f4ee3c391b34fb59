# demo.gp: `data`, the reactions.csv of demo.sh -> `picture`. A column for each table of the paper; above
# the reactions, in the middle their differences from the paper's, below those from Lemke's method. A
# difference of 0 is not drawn.
set datafile separator ','
set terminal pngcairo size 1600,1100 font ',11'
set output picture
set multiplot
set grid
set key off
set xrange [0.2:16.8]
set xtics 2
methods = 'auto nlgs lemke newton admm augmented-lagrangian penalty gauss-seidel jean'
# colours and points of src/cli/palette.c; jean, the iteration of the paper, has its own
colours = '#000000 #e69f00 #cc79a7 #0072b2 #009e73 #d55e00 #999999 #b8860b #882255'
points = '13 6 15 5 9 11 4 10 2'
row(s, k, c) = strcol(1) eq s && strcol(2) eq k && strlen(strcol(c)) ? column(c) : NaN
pick(s, k, m, c) = strcol(3) eq m ? row(s, k, c) : NaN
seen(x) = x > 0 ? x : NaN
left(c) = 0.05 + 0.24 * c
do for [c=0:3] {
  scene = c < 2 ? 'fig3' : 'fig4'
  kind = c % 2 ? 'weighted' : 'concentrated'
  unset logscale y
  set format y '%g'
  set lmargin at screen left(c) + 0.012; set rmargin at screen left(c) + 0.213
  set tmargin at screen 0.955; set bmargin at screen 0.70
  set title sprintf("Fig. %s, %s", c < 2 ? "3" : "4", kind)
  set xlabel ''
  set ylabel (c ? '' : 'reaction [kN/m]')
  set yrange [*:*]
  plot data using 4:(pick(scene, kind, 'lemke', 6) / 1e3) with lines dt 2 lw 1.5 lc rgb '#0072b2' notitle, \
       '' using 4:(pick(scene, kind, 'lemke', 5) / 1e3) with lines dt 2 lw 1.5 lc rgb '#d55e00' notitle, \
       '' using 4:(pick(scene, kind, 'lemke', 8) / 1e3) with points pt 7 ps 0.9 lc rgb '#0072b2' notitle, \
       '' using 4:(pick(scene, kind, 'lemke', 7) / 1e3) with points pt 5 ps 0.9 lc rgb '#d55e00' notitle
  unset title
  set logscale y
  set format y '10^{%T}'
  set tmargin at screen 0.665; set bmargin at screen 0.41
  set ylabel (c ? '' : 'difference from the paper, relative')
  set yrange [1e-8:1e-1]
  plot for [m=1:9] data using 4:(seen(pick(scene, kind, word(methods, m), 9))) with points \
       pt int(word(points, m)) ps 1 lc rgb word(colours, m) notitle
  set tmargin at screen 0.375; set bmargin at screen 0.12
  set xlabel 'node, from the free face'
  set ylabel (c ? '' : "difference from Lemke's method, relative")
  set yrange [1e-17:1e-1]
  set ytics 1e-17, 1e2
  plot for [m=1:9] data using 4:(seen(pick(scene, kind, word(methods, m), 10))) with points \
       pt int(word(points, m)) ps 1 lc rgb word(colours, m) notitle
  set ytics autofreq
}
# the key of all of them
unset logscale
unset title; unset xlabel; unset ylabel; unset tics; unset border; unset grid
set lmargin at screen 0.03; set rmargin at screen 0.99
set bmargin at screen 0.01; set tmargin at screen 0.07
set xrange [0:1]; set yrange [0:1]
set key on center center horizontal reverse Left samplen 3 width 1
plot NaN with lines dt 2 lw 1.5 lc rgb '#0072b2' title 'R_N, all methods', \
     NaN with points pt 7 lc rgb '#0072b2' title 'R_N, the paper', \
     NaN with lines dt 2 lw 1.5 lc rgb '#d55e00' title 'R_T, all methods', \
     NaN with points pt 5 lc rgb '#d55e00' title 'R_T, the paper', \
     for [m=1:9] NaN with points pt int(word(points, m)) lc rgb word(colours, m) title word(methods, m)
unset multiplot
