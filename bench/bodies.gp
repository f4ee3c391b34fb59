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
set ylabel "speed-up of a sweep"
set key outside right
set grid
sizes = system("awk -F, 'NR > 1 && !seen[$2]++ {print $2}' ".csv)
set terminal pngcairo size 900,520 font ',12'
set output dir."bodies.png"
plot x title "threads" lc rgb "gray", \
     for [k=1:words(sizes)] csv every ::1 using (strcol(1) eq 'bodies' && $2 == word(sizes, k) + 0 ? $3 : NaN):5 with lines dt 2 lw 2 lc k title "model: bodies, ".word(sizes, k), \
     for [k=1:words(sizes)] csv every ::1 using (strcol(1) eq 'blocks' && $2 == word(sizes, k) + 0 ? $3 : NaN):5 with lines dt 3 lw 2 lc k title "model: blocks, ".word(sizes, k), \
     for [k=1:words(sizes)] csv every ::1 using (strcol(1) eq 'bodies' && $2 == word(sizes, k) + 0 && $3 == 2 ? $3 : NaN):6 with points pt 7 lc k title "measured: bodies, ".word(sizes, k), \
     for [k=1:words(sizes)] csv every ::1 using (strcol(1) eq 'blocks' && $2 == word(sizes, k) + 0 && $3 == 2 ? $3 : NaN):6 with points pt 6 lc k title "measured: blocks, ".word(sizes, k)
