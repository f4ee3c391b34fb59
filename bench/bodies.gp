# bodies.gp: draws the model of bodies.c, speed-up of a sweep on 1 to 64 threads, beside what two threads gave.
# gnuplot -e "dir='bench/results/'" bench/bodies.gp
if (!exists("dir")) dir = "bench/results/"
csv = dir."bodies.csv"
set datafile separator ","
set logscale xy
set xrange [1:64]
set yrange [1:64]
set xtics (1, 2, 4, 8, 16, 32, 64)
set ytics (1, 2, 4, 8, 16, 32, 64)
set xlabel "threads"
set ylabel "one thread over this many"
set key left top
set grid
sizes = system("awk -F, 'NR > 1 && !seen[$2]++ {print $2}' ".csv)
do for [type in "png svg"] {
  if (type eq 'png') { set terminal pngcairo size 760,520 font ',12' }
  if (type eq 'svg') { set terminal svg size 760,520 font ',12' background 'white' }
  set output dir."bodies.".type
  plot x title "all of them" lc rgb "gray", \
       for [n in sizes] csv every ::1 using (strcol(1) eq 'bodies' && $2 == n + 0 ? $3 : NaN):5 with linespoints pt 1 lw 2 title "bodies, ".n, \
       for [n in sizes] csv every ::1 using (strcol(1) eq 'blocks' && $2 == n + 0 ? $3 : NaN):5 with linespoints pt 1 dt 2 title "blocks, ".n, \
       csv every ::1 using ($3 == 2 ? $3 : NaN):6 with points pt 7 lc rgb "black" title "measured"
}
