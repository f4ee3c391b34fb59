# mpi.gp: draws the model of docs/mpi.md, seconds of the factor on 1 to 64 ranks, beside the runs of mpi.csv.
# gnuplot -e "dir='bench/results/'" bench/mpi.gp
if (!exists("dir")) dir = "bench/results/"
csv = dir."mpi.csv"
set datafile separator ","
# the rate of one rank, from its run at 30^3; the network: 10 GB/s a rank
stats csv using ($1 == 30 && $2 == 1 ? $34 / $12 : NaN) every ::1 name "R" nooutput
R = R_max
network = 1e10
n(c) = 3.0 * c * (c + 1)**2
flops(c) = 32.5 * n(c)**2
# bytes of the factor: 272 n^(4/3) is what MUMPS uses on one rank at 30^3
bytes(c) = 272 * n(c)**(4.0 / 3)
# what both shares of 30^3 compute on two ranks, over one rank: narrower blocks, assembly, copies
stats csv using ($1 == 30 && $2 == 1 ? $13 : NaN) every ::1 name "ALONE" nooutput
stats csv using ($1 == 30 && $2 == 2 ? $13 : NaN) every ::1 name "BOTH" nooutput
loss(p) = p > 1 ? BOTH_max / ALONE_max : 1
factor(c, p) = loss(p) * flops(c) / (R * p) + (p > 1 ? bytes(c) / network : 0)
set logscale xy
set xrange [1:64]
set xtics (1, 2, 4, 8, 16, 32, 64)
set format y '10^{%T}'
set xlabel "ranks"; set ylabel "CPU of the factor, a rank [s]"
set grid lc rgb '#d8d8d8'; set key outside right top Left reverse
set title 'The CPU of a rank falls with the ranks'
set terminal pngcairo size 860,460 font ',13'; set output dir."mpi.png"
cubes = "22 30 60 100"
colour(k) = word("#0072b2 #009e73 #d55e00 #cc79a7", k)
plot for [k=1:2] csv every ::1 using ($1 == word(cubes, k) + 0 ? $2 : NaN):12 with points pt 7 ps 1.6 lc rgb colour(k) title "measured, ".word(cubes, k)."^3 elements", \
     for [k=1:4] factor(word(cubes, k) + 0, x) with lines dt 2 lw 2 lc rgb colour(k) title "model, ".word(cubes, k)."^3"
