# bodies.gp: draws the model of bodies.c, speed-up of a sweep over bodies on 1 to 64 threads, beside what two threads gave.
# gnuplot -e "dir='bench/results/'" bench/bodies.gp
if (!exists("dir")) dir = "bench/results/"
csv = dir."bodies.csv"
set datafile separator ","
set logscale x
set xrange [0.9:64]
set yrange [0.9:2.5]
set xtics (1, 2, 4, 8, 16, 32, 64)
set xlabel "threads"; set ylabel "speed-up of a sweep"
set grid lc rgb '#d8d8d8'; set key outside right top Left reverse
set title 'By the model more than two threads hardly help'
sizes = system("awk -F, 'NR > 1 && !seen[$2]++ {print $2}' ".csv)
colour(k) = word("#0072b2 #009e73 #d55e00", k)
set terminal pngcairo size 860,460 font ',13'; set output dir."bodies.png"
plot for [k=1:words(sizes)] csv every ::1 using (strcol(1) eq 'bodies' && $2 == word(sizes, k) + 0 && $3 == 2 ? $3 : NaN):6 with points pt 7 ps 1.6 lc rgb colour(k) title "measured, ".word(sizes, k)." contacts", \
     for [k=1:words(sizes)] csv every ::1 using (strcol(1) eq 'bodies' && $2 == word(sizes, k) + 0 ? $3 : NaN):5 with lines dt 2 lw 2 lc rgb colour(k) title "model, ".word(sizes, k)
