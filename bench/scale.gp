# scale.gp: scale.csv -> scale.png, in `dir`: CPU of auto against contacts, every kind, and of Siconos.
if (!exists('dir')) dir = 'bench/results/'
# rows contacts, seconds of the kinds of a group, a blank line between kinds
part(group, column) = "< awk -F, 'NR > 1 && $1 ~ /^(".group.")/ { if ($1 != last) print \"\"; last = $1; ".\
                      "if ($".column." != \"\") print $2, $".column." }' '".dir."scale.csv'"
set logscale xy
set format xy '10^{%T}'
set xrange [200:30000]
set yrange [1e-4:10]
set grid lc rgb '#d8d8d8'; set key outside right top Left reverse
set title 'CPU of a solve to 1e-4, each kind of problem a line; measured'
set xlabel 'contacts'; set ylabel 'CPU [s]'
set label '1 us a contact' at 2000,0.0009 left tc rgb '#606060'
set label '100 us' at 600,0.11 left tc rgb '#606060'
set terminal pngcairo size 860,500 font ',13'; set output dir.'scale.png'
plot 1e-6 * x with lines dt 3 lw 2 lc rgb '#808080' notitle, 1e-4 * x with lines dt 3 lw 2 lc rgb '#808080' notitle, \
     part('wall|rubble|chain|arch|tower', '3') with linespoints pt 7 lc rgb '#0072b2' title 'auto: masonry', \
     part('packing|discs|balls|mixed', '3') with linespoints pt 9 ps 1.2 lc rgb '#009e73' title 'auto: grains', \
     part('elastic', '3') with linespoints pt 5 lc rgb '#e69f00' title 'auto: elastic', \
     part('.', '5') with points pt 6 ps 1.3 lw 1.5 lc rgb '#b00020' title 'Siconos NSGS'
unset output
