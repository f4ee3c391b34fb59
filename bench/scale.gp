# scale.gp: scale.csv -> scale.png, in `dir`: CPU time against candidates.
# The colours are of src/cli/palette.c: blue is delassus, warm the peer.
if (!exists('dir')) dir = 'bench/results/'
data = dir.'scale.csv'
set datafile separator ','
set datafile missing NaN # the line goes on over it
set logscale xy
set key left top reverse Left
set grid
set xlabel 'candidates'
set ylabel 's'
set offsets 0, 0, graph 0.35, 0
kinds = system("tail -n +2 '".data."' | cut -d, -f1 | uniq | tr '\\n' ' '")
columns = words(kinds) < 4 ? words(kinds) : 4
rows = (words(kinds) + columns - 1) / columns
# column c of the rows of kind k
pick(k, c) = strcol(1) eq k ? column(c) : NaN
set terminal pngcairo size 380*columns,360*rows font ',11'
set output dir.'scale.png'
set multiplot layout rows,columns
do for [kind in kinds] {
  set title kind
  plot data using 2:(pick(kind, 5)) with linespoints pt 6 lc rgb '#d55e00' title 'Siconos, blocks', \
       '' using 2:(pick(kind, 4)) with linespoints pt 9 lc rgb '#56b4e9' title 'best other of delassus', \
       '' using 2:(pick(kind, 3)) with linespoints pt 7 lc rgb '#0072b2' title 'auto', \
       '' using 2:(pick(kind, 3) * 0 + 1e-6 * column(2)) with lines dt 3 lc rgb '#999999' title '1 us a candidate'
}
unset multiplot
unset output
