# papers.gp: papers_*.csv -> papers_*.png, in `dir`: a picture for each question of papers.c but the
# first, which examples/demo.gp draws. The colours are of src/cli/palette.c; a model is dashed grey.
if (!exists('dir')) dir = 'bench/results/'
set datafile separator ','
set grid
blue = '#0072b2'; red = '#d55e00'; green = '#009e73'; purple = '#cc79a7'; grey = '#888888'
when(c) = c ? 1 : NaN
set style line 1 lc rgb grey dt 2 lw 2

# ---- weighted or concentrated
set terminal pngcairo size 1500,520 font ',11'
set output dir.'papers_refinement.png'
set multiplot layout 1,3
file = dir.'papers_pressure.csv'
set title 'Normal density at the nodes, friction 1'
set xlabel 'x [mm]'
set ylabel 'density of reaction [GPa]'
set xrange [0.8:3.8]; set yrange [-0.05:1.25]
set key bottom right reverse Left
of(s, n) = when(strcol(1) eq s && column(2) == n)
plot file using ($3 * 1e3):(of('reference', 512) * $6 * 1e-9) with lines dt 2 lw 2 lc rgb grey title 'reference, 512x256', \
     '' using ($3 * 1e3):(of('mesh', 16) * $4 * 1e-9) with points pt 7 lc rgb red title 'weighted, 16x8', \
     '' using ($3 * 1e3):(of('mesh', 16) * $6 * 1e-9) with points pt 5 lc rgb blue title 'concentrated, 16x8', \
     '' using ($3 * 1e3):(of('mesh', 64) * $4 * 1e-9) with points pt 6 ps 0.7 lc rgb red title 'weighted, 64x32', \
     '' using ($3 * 1e3):(of('mesh', 64) * $6 * 1e-9) with points pt 4 ps 0.7 lc rgb blue title 'concentrated, 64x32'
file = dir.'papers_errors.csv'
set logscale xy
set format '10^{%T}'
set xlabel 'side of an element [mm]'
set ylabel 'error of the density, relative'
set xrange [0.02:0.8]; set yrange [3e-7:1]
set key opaque
set xtics (0.03, 0.06, 0.125, 0.25, 0.5) ; set format x '%g'
do for [mu in '1 0.2'] {
  set title 'Error, friction '.mu
  pick(s, p) = when(column(1) == real(s) && strcol(2) eq p)
  plot for [p in 'whole smooth'] for [c=4:6] file using ($3 * 1e3):(pick(mu, p) * column(c)) with points \
       pt (word('7 9 5', c - 3) - (p eq 'smooth')) lc rgb word(red.' '.green.' '.blue, c - 3) \
       title word('"weighted" "weighted, P r" "concentrated"', c - 3).(p eq 'whole' ? ', 0' : ', 2').' to 3 mm', \
       0.4 * x with lines ls 1 title 'model: h', 0.04 * x**2 with lines lc rgb grey dt 4 lw 2 title 'model: h^2'
}
unset multiplot
unset logscale
set xtics autofreq

# ---- Aitken or over-relaxation
set terminal pngcairo size 1500,860 font ',11'
set output dir.'papers_aitken.png'
set multiplot layout 2,3
set logscale xy
set format '10^{%T}'
name(c) = word('"fig3 32x16, friction 1" "fig4 32x16, friction 0.1" "fig3 64x32, friction 0.3"', c + 1)
file = dir.'papers_aitken.csv'
set key top right reverse Left
set xlabel 'CPU [ms]'
set ylabel 'residual'
set xrange [1e-2:3e3]; set yrange [1e-9:1e7]
run(c, k, w) = when(column(1) == c && strcol(2) eq k && strcol(3) eq w)
do for [c=0:2] {
  set title name(c).', tolerance 1e-8, limit 20,000 sweeps'
  way(k) = word('aitken best plain', k)
  shade(k) = word(blue.' '.red.' '.grey, k)
  named(k) = word('"Aitken" "best omega" "plain"', k)
  plot for [k=1:3] file using ($6 * 1e3):(run(c, 'K', way(k)) * $7) with lines lw 2 lc rgb shade(k) title 'on K: '.named(k), \
       for [k=1:3] file using ($6 * 1e3):(run(c, 'W', way(k)) * $7) with lines lw 2 dt 3 lc rgb shade(k) title 'on W: '.named(k)
}
file = dir.'papers_omega.csv'
unset logscale x
set format x '%g'
set xlabel 'omega'
set ylabel 'CPU to 1e-8 [ms]'
set xrange [0.45:2]; set yrange [1e-1:1e6]
on(c, k) = when(column(1) == c && strcol(2) eq k)
do for [c=0:2] {
  set title name(c).': no point, limit reached'
  plot file using 3:(on(c, 'K') * $5 * 1e3) with points pt 7 lc rgb red title 'on K: omega', \
       '' using 3:(on(c, 'K') * $7 * 1e3) with lines lw 2 lc rgb blue title 'on K: Aitken', \
       '' using 3:(on(c, 'W') * $5 * 1e3) with points pt 6 lc rgb red title 'on W: omega', \
       '' using 3:(on(c, 'W') * $7 * 1e3) with lines lw 2 dt 3 lc rgb blue title 'on W: Aitken'
}
unset multiplot
unset logscale

# ---- penalty
set terminal pngcairo size 1200,520 font ',11'
set output dir.'papers_penalty.png'
set multiplot layout 1,2
file = dir.'papers_penalty.csv'
set logscale xy
set format '10^{%T}'
set xlabel 'penalty over the stiffness of the contact node'
set ylabel 'relative error'
set xrange [0.5:2e15]; set yrange [1e-16:1e8]
set title 'Error of the reactions, and penetration'
is(s) = when(strcol(1) eq s)
plot for [k=1:3] for [c=3:4] file using 2:(is(word('fig3-16 fig3-64 indentation', k)) * column(c)) with points \
     pt (word('7 5 9', k) + 3 - c) lc rgb word(blue.' '.red.' '.green, k) \
     title word('"block 16x8" "block 64x32" "indentation"', k).': '.(c == 3 ? (k < 3 ? 'reactions' : 'force') : 'penetration / '.(k < 3 ? 'largest gap' : 'travel')), \
     1 / x with lines ls 1 title 'model: 1 / s'
set format y '%g'
set ylabel 'Newton steps'
set title "Newton steps: block, and indentation in 40 steps"
set yrange [0.5:5000]
plot file using 2:(is('fig3-16') * $5) with points pt 7 lc rgb blue title 'block 16x8', \
     '' using 2:(is('fig3-64') * $5) with points pt 5 lc rgb red title 'block 64x32', \
     '' using 2:(is('indentation') * $5) with points pt 9 lc rgb green title 'indentation'
unset multiplot
unset logscale

# ---- Lemke
set output dir.'papers_lemke.png'
set multiplot layout 1,2
file = dir.'papers_lemke.csv'
set logscale xy
set format '10^{%T}'
set key top left
set xlabel 'rows of the LCP, 3 for each contact'
set ylabel 'pivots, rounds of the crash start'
set xrange [15:6e3]; set yrange [1:1e5]
set title 'Pivots'
plot for [c=4:6:2] for [k in 'block lining'] file using 3:(is(k) * column(c)) with points \
     pt ((c == 4 ? 7 : 6) - 2 * (k eq 'lining')) lc rgb (c == 4 ? purple : blue) title k.(c == 4 ? ': path' : ': crash start'), \
     x / 3 with lines ls 1 title 'model: one pivot a contact'
set ylabel 'CPU [s]'
set yrange [1e-6:1e3]
set title 'CPU, without the condensation'
plot for [c=5:7:2] for [k in 'block lining'] file using 3:(is(k) * column(c)) with points \
     pt ((c == 5 ? 7 : 6) - 2 * (k eq 'lining')) lc rgb (c == 5 ? purple : blue) title k.(c == 5 ? ': path' : ': crash start'), \
     '' using 3:(is('block') * $8) with points pt 13 lc rgb 'black' title 'block: auto', \
     '' using 3:(is('lining') * $8) with points pt 12 lc rgb 'black' title 'lining: auto', \
     3e-11 * x**3 with lines ls 1 title 'model: n^3', 5e-9 * x**2 with lines lc rgb grey dt 4 lw 2 title 'model: n^2'
unset multiplot
unset logscale

# ---- (12) or (6)
set xrange [*:*]; set yrange [*:*]
set format '%g'
file = dir.'papers_return.csv'
stats file using (is('indentation') * $5) nooutput
dent = STATS_max
stats file using (is('extrusion') * $5) nooutput
squeeze = STATS_min
set output dir.'papers_flow.png'
set multiplot layout 1,2
file = dir.'papers_flow.csv'
set logscale xy
set format '10^{%T}'
set key bottom left
set xlabel 'steps of the path'
set ylabel 'error of the stress at the end, relative'
set xrange [3:6e3]; set yrange [1e-7:1]
set title 'A point: error beside (6) in 65,536 steps'
point(m, p) = when(strcol(1) eq m && column(2) == p)
plot for [c=4:5] for [m in 'indentation extrusion'] for [p=0:1] file using 3:(point(m, p) * column(c)) with points \
     pt ((m eq 'indentation' ? 7 : 5) - p) lc rgb (c == 4 ? red : blue) \
     title (c == 4 ? '(12), ' : '(6), ').m.(p ? ', shear and stretch' : ', shear'), \
     1.5 / x with lines ls 1 title 'model: 1 / steps'
unset logscale y
set format y '%g'
file = dir.'papers_return.csv'
set key top right
set xlabel 'steps of the scene'
set ylabel 'force at the end, over that of (6) with most steps'
set xrange [20:2e3]; set yrange [0.996:1.01]
set title 'Forces of the scenes'
plot file using 2:(is('indentation') * $3 / dent) with points pt 7 lc rgb red title '(12), indentation', \
     '' using 2:(is('extrusion') * $3 / squeeze) with points pt 5 lc rgb red title '(12), extrusion', \
     '' using 2:(is('indentation') * $5 / dent) with points pt 6 lc rgb blue title '(6), indentation', \
     '' using 2:(is('extrusion') * $5 / squeeze) with points pt 4 lc rgb blue title '(6), extrusion'
unset multiplot
unset logscale

# ---- negative entries of P
set output dir.'papers_weighting.png'
set multiplot layout 1,2
file = dir.'papers_line.csv'
set format '%g'
set key bottom right
set xlabel 'x, width of the block 4'
set ylabel 'density of reaction over the pressure on top'
set xrange [0:4]; set yrange [-1:2.5]
set title 'Normal density, 16 contacts, friction 0.2'
kind(s, r) = when(strcol(1) eq s && strcol(2) eq r)
plot file using 3:(kind('linear edges', 'concentrated') * $4) with points pt 4 lc rgb blue title 'linear, concentrated', \
     '' using 3:(kind('linear edges', 'weighted') * $4) with points pt 6 lc rgb red title 'linear, weighted', \
     '' using 3:(kind('quadratic edges', 'concentrated') * $4) with points pt 5 lc rgb blue title 'quadratic, concentrated', \
     '' using 3:(kind('quadratic edges', 'weighted') * $4) with points pt 7 lc rgb red title 'quadratic, weighted: P has entries < 0'
file = dir.'papers_weighting.csv'
set logscale xy
set format y '10^{%T}'
set xtics (0.0625, 0.125, 0.25, 0.333, 0.667)
set xlabel 'distance of nodes, width of the block 4'
set ylabel 'error of the density at 2 to 3, relative'
set xrange [0.05:0.9]; set yrange [3e-8:1]
set title 'Error beside a mesh of at least 4 times as many nodes'
plot for [k=1:4] for [r=1:2] file using \
     3:(kind(word('"linear edges" "quadratic edges" "four-node faces" "nine-node faces"', k), word('concentrated weighted', r)) * $4) with points \
     pt (word('4 6 5 7 8 8 9 9', 2 * k + r - 2) + 0) lc rgb (r == 1 ? blue : red) \
     title word('linear quadratic "3D four-node" "3D nine-node"', k).', '.word('concentrated weighted', r), \
     0.05 * x**2 with lines ls 1 title 'model: h^2'
unset multiplot
