/*
 * constants.h: the numbers that steer auto: value, unit, reason. None is tuned beyond a factor of
 * 2: bench/constants.sh [NAME...] halves and doubles each (bench/results/constants.md), and
 * `make bench-auto BENCH=--price` measures group 3. What may be halved or doubled without a change
 * stands where it is used, constants of a method in its file.
 */
#ifndef DLSI_AUTO_CONSTANTS_H
#define DLSI_AUTO_CONSTANTS_H

/* clang-format off */

/* ---- 1. Regimes and what is open to them: sizes (plan.c) ----------------------------------- */
enum {                             /* unit      reason */
  dlsi_auto_few             = 100, /* contacts  W by blocks: more are a packing */
  dlsi_auto_many            = 1000,/* contacts  more are not swept with Anderson alone */
  dlsi_auto_split_least     = 100, /* rows      fewer are solved before ADMM has its factors */
  dlsi_auto_rest_least      = 150, /* rows      the same of the convex problem */
  dlsi_auto_few_rows        = 180, /* rows      W dense: factors take less than paths and pivots */
  dlsi_auto_small           = 300, /* rows      1000 factorisations take some seconds: searches */
  dlsi_auto_large           = 3000,/* rows      more: no second method from r = 0, no late table */
  dlsi_auto_early_rows      = 400, /* LCP rows  its table stays in the cache: pivots before sweeps
                                                go on */
  dlsi_auto_loose_blocks    = 4    /* blocks a contact, its own included: factors cost few sweeps */
};

/* ---- 2. Plans: iterations (plan.c) ---------------------------------------------------------- */
enum {
  dlsi_auto_splits          = 200, /* ADMM, before Newton again or pivots: more cost more */
  dlsi_auto_few_pushes      = 200, /* momentum, few contacts: before pivots */
  dlsi_auto_most_failures   = 5    /* failures that count: each doubles patience; a copy
                                      begins with so many */
};

/* ---- 3. The cost model (price.c), in sweeps with Anderson's acceleration --------------------- */
enum { dlsi_auto_most_of_step = 50 };             /* sweeps: a step of Newton, before fill */
static const double dlsi_auto_step_sweeps = 1.5;  /* sweeps: a step on kept factors */

/* ---- 4. The forecast (forecast.c) ----------------------------------------------------------- */
enum {
  dlsi_auto_look_every      = 5,   /* sweeps from look to look */
  dlsi_auto_first_sweeps    = 10,  /* sweeps before a forecast is believed, ... */
  dlsi_auto_first_of_few    = 60,  /* ... of few contacts by blocks: a sweep costs nothing there */
  dlsi_auto_ahead           = 100, /* sweeps ahead: the convex problem or momentum takes fewer */
  dlsi_auto_sweeps_before   = 200, /* sweeps before the convex problem of what is not at rest; four
                                    times as many although the answer seems near */
  dlsi_auto_first_patience  = 4,   /* steps of Newton without progress, at least ... */
  dlsi_auto_last_patience   = 12   /* ... and at most: that of vi/newton/newton.c */
};
static const double dlsi_auto_unsorted  = .05;  /* residual: above, few states are the answer's */
static const double dlsi_auto_far_start = .25;  /* residual of a warm start with many new states */
static const double dlsi_auto_push_near = 1e-5; /* residual: above, Newton fails on packings */

/* ---- 5. Rest, warm solves, accuracy, verdicts ------------------------------------------------ */
static const double dlsi_auto_share_outside = .1; /* of -q outside of the cones: may be at rest */
static const double dlsi_auto_firm = 1e4;         /* friction: larger ones are this on a copy */
static const double dlsi_auto_accurate = 1e-4;    /* relative error of r that needs no word */

/* clang-format on */

#endif
