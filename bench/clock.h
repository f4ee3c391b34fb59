/* clock.h: the clock of the benchmarks. */
#ifndef CLOCK_H
#define CLOCK_H

/* CPU seconds of this process, all threads: a BLAS with threads would not go unseen. */
double cpu_seconds(void);

#endif
