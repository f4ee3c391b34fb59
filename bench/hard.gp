# hard.gp: hard.csv in `dir` -> `picture`: the ending of each method on the problems with 30 contacts.
# A panel for each method (row) and degeneracy (column), a cell for each conditioning and friction,
# half a cell for each of two seeds.
if (!exists('dir')) dir = 'bench/results/'
if (!exists('picture')) picture = 'docs/pictures/hard.png'
data = dir.'hard.csv'
set datafile separator ','
contacts = 30
methods = 'auto nlgs nlgs+aitken nlgs+anderson nlgs+momentum newton admm augmented-lagrangian lemke homotopy'
flaws = '"full rank" "half rank" "on the border" "half bonded"'
endings = 'solved cycle ray "no progress" "reports none" "not decided" "not applicable"'
# colours of src/cli/palette.c; not decided and not applicable are no failures, and pale
colours = '#0072b2 #f0e442 #cc79a7 #e69f00 #882255 #bbbbbb #f4f4f4'
row(x) = x < 1e-9 ? 0 : x < 0.5 ? 1 : x < 1.5 ? 2 : x < 3 ? 3 : 4
column_of(x) = log10(x) / 2
is(f, m, e) = column(2) == contacts && column(1) == f && column(6) == m && column(7) == e ? 1 : NaN
set terminal pngcairo size 1200,1200 font ',11'
set output picture
set multiplot
set border lw 0.5
set style fill solid 1 noborder
set xrange [-0.5:4.5]; set yrange [-0.5:4.5]
set key off
set tics out scale 0.4 nomirror
left(f) = 0.215 + 0.193 * f
top(m) = 0.972 - 0.0895 * m
do for [m=0:9] {
  do for [f=0:3] {
    set lmargin at screen left(f); set rmargin at screen left(f) + 0.18
    set tmargin at screen top(m); set bmargin at screen top(m) - 0.078
    set title ''
    if (m == 0) { set title word(flaws, f + 1) offset 0,-0.4 }
    set xtics ('' 0, '' 1, '' 2, '' 3, '' 4)
    set xlabel ''
    if (m == 9) { set xtics ('1' 0, '10^2' 1, '10^4' 2, '10^6' 3, '10^8' 4); set xlabel 'condition of W' offset 0,0.3 }
    set ytics ('' 0, '' 1, '' 2, '' 3, '' 4)
    set ylabel ''
    if (f == 0) { set ytics ('0' 0, '0.3' 1, '1' 2, '2' 3, '5' 4); set ylabel 'friction' offset 0.5,0 }
    unset label
    if (f == 0) { set label word(methods, m + 1) at screen 0.01, screen (top(m) - 0.037) }
    plot for [e=0:6] data using (column_of($3) + 0.24 * ($5 - 3)):(row($4) * is(f, m, e)):(0.22):(0.46) \
         with boxxyerror lc rgb word(colours, e + 1)
  }
}
unset label; unset title; unset xlabel; unset ylabel; unset tics; unset border
set lmargin at screen 0.05; set rmargin at screen 0.98
set bmargin at screen 0.005; set tmargin at screen 0.04
set xrange [0:1]; set yrange [0:1]
set key on center center horizontal reverse Left samplen 1.5 width 1
plot for [e=1:7] NaN with boxes lc rgb word(colours, e) title word(endings, e)
unset multiplot
