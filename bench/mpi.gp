# mpi.gp: draws the model of docs/mpi.md, seconds of factor and solve on 1 to 64 ranks, beside the runs of mpi.csv.
# gnuplot -e "dir='bench/results/'" bench/mpi.gp
if (!exists("dir")) dir = "bench/results/"
csv = dir."mpi.csv"
set datafile separator ","
# the rate of one rank, from its run at 30^3; the network: 2 us, 10 GB/s a rank
stats csv using ($1 == 30 && $2 == 1 ? $34 / $12 : NaN) every ::1 name "R" nooutput
R = R_max
latency = 2e-6
network = 1e10
memory = 8e9
n(c) = 3.0 * c * (c + 1)**2
m(c) = 3.0 * c * (c + 1)
log2(p) = log(p) / log(2)
flops(c) = 32.5 * n(c)**2
# bytes of the factor: 272 n^(4/3) is what MUMPS uses on one rank at 30^3
bytes(c) = 272 * n(c)**(4.0 / 3)
# what both shares of 30^3 compute on two ranks, over one rank: narrower blocks, assembly, copies
stats csv using ($1 == 30 && $2 == 1 ? $13 : NaN) every ::1 name "ALONE" nooutput
stats csv using ($1 == 30 && $2 == 2 ? $13 : NaN) every ::1 name "BOTH" nooutput
loss(p) = p > 1 ? BOTH_max / ALONE_max : 1
factor(c, p) = loss(p) * flops(c) / (R * p) + (p > 1 ? bytes(c) / network : 0)
# a factor and inverse of W + rho D, and 45 iterations: half of W from the memory, a reduce and a broadcast of m numbers
solve(c, p) = loss(p) * m(c)**3 / (R * p) + 45 * (4 * m(c)**2 / p / memory + 2 * log2(p) * (latency + 8 * m(c) / network))
set logscale xy
set xrange [1:64]
set xtics (1, 2, 4, 8, 16, 32, 64)
set xlabel "ranks"
set ylabel "CPU seconds of a rank"
set key outside right
set grid
set terminal pngcairo size 900,520 font ',12'
set output dir."mpi.png"
cubes = "22 30 60 100"
plot for [k=1:4] factor(word(cubes, k) + 0, x) title "model: factor, ".word(cubes, k)."^3 cubes" dt 2 lw 2 lc k, \
     for [k=1:4] solve(word(cubes, k) + 0, x) title "model: solve, ".word(cubes, k)."^3 cubes" dt 3 lw 2 lc k, \
     for [k=1:2] csv every ::1 using ($1 == word(cubes, k) + 0 ? $2 : NaN):12 with points pt 7 lc k title "measured: factor, ".word(cubes, k)."^3", \
     for [k=1:2] csv every ::1 using ($1 == word(cubes, k) + 0 ? $2 : NaN):24 with points pt 6 lc k title "measured: solve, ".word(cubes, k)."^3"
