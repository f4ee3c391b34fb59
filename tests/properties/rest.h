/*
 * rest.h: bodies at rest, warm, held by penalties or joints: K x = f + H r, u = H' x + g, d = 2,
 * with a planted answer, or a motion that shows that there is none. All numbers are short, so that
 * f = K x - H r and g = u - H' x are exact.
 *
 *   statics    rigid bodies, K = 0, x = 0: reactions in equilibrium with the loads
 *   falls      the same with a motion y: H_N' y >= mu |H_T' y| at each contact and f.y > 0. Then
 *              y.(f + H r) >= f.y for all r in their cones, and nothing balances (Farkas)
 *   impulse    rigid bodies, K their masses
 *   joints     the same with hinges among the unknowns, friction 1 to 3
 *   free       elastic bodies that contact alone holds, friction to 64
 *   heat       one such body, loaded by K x of 1 to 1e8 times the reactions
 *   held       the same, held at two corners by springs as stiff as itself
 *   penalty    the same, its corner moved by a number of 1e8 to 1e30 on the diagonal
 */
#ifndef PROPERTIES_REST_H
#define PROPERTIES_REST_H

#include <stdint.h>

#include "delassus/status.h"

enum { REST_UNKNOWNS = 128, REST_CONTACTS = 24, REST_BODIES = 4 };

typedef enum rest_kind {
  REST_STATICS,
  REST_FALLS,
  REST_IMPULSE,
  REST_JOINTS,
  REST_FREE,
  REST_HEAT,
  REST_HELD,
  REST_PENALTY,
  REST_KINDS
} rest_kind;

typedef struct rest {
  rest_kind kind;
  int n, nc, bodies;
  double K[REST_UNKNOWNS][REST_UNKNOWNS];
  double H[REST_UNKNOWNS][2 * REST_CONTACTS];  /* columns n and t of each contact */
  double f[REST_UNKNOWNS], own[REST_UNKNOWNS]; /* own: the part of f that balances in itself */
  double g[2 * REST_CONTACTS], mu[REST_CONTACTS];
  double x[REST_UNKNOWNS], r[2 * REST_CONTACTS]; /* planted; falls: x = y */
  int body[REST_UNKNOWNS];                       /* of an unknown; -1: force of a joint */
  int fixed[REST_UNKNOWNS];                      /* 1: moved by a penalty, to x */
  int motions[REST_BODIES];                      /* of a body: 3 where nothing else holds it */
  double motion[3][REST_UNKNOWNS];               /* of all bodies, each on its own unknowns */
} rest;

/* p := the problem of this seed and kind, the same bits at every call. */
void rest_generate(rest_kind of, uint64_t seed, rest *p);

typedef enum rest_verdict {
  REST_RIGHT = 0,
  REST_REFUSED, /* not solved although planted */
  REST_CLAIMED, /* from here on untrue: solved, and there is no answer */
  REST_DENIED,  /* "no solution" although planted */
  REST_MOTION,  /* a force or moment of a body is not balanced */
  REST_ROWS,    /* K x = f + H r does not hold */
  REST_CONE,    /* a reaction pulls or leaves its cone */
  REST_LAW,     /* H' x + g and r do not meet the laws */
  REST_VERDICTS
} rest_verdict;

/* Judges an answer in long double. Balances are over |f - own| + |H||r| of the body, positions over
 * |g| and |H|'|x|, and to 4e-8 over indentations. */
rest_verdict rest_judge(const rest *p, dls_status status, const double *x, const double *r);

/* Solves `count` problems of each kind, or of one (which < REST_KINDS), on W or K as the library
 * chooses, and prints how many are right, refused and untrue. Returns 1 if none is untrue. */
int rest_run(uint64_t seed, uint64_t step, long count, int which);

/* Returns the kind of this name, REST_KINDS for "rest", else -1. */
int rest_kind_of(const char *name);

#endif
