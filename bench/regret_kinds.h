/* regret_kinds.h: contact problems of bench/regret, of any size, friction and seed. */
#ifndef REGRET_KINDS_H
#define REGRET_KINDS_H

#include <stdint.h>

#include "delassus.h"
#include "rigid.h"

/* A problem and the memory that its view needs. */
typedef struct regret_problem {
  dls_contact contact;
  rigid bodies; /* where a kind of tests/shared/rigid.h is the origin */
  rigid own;    /* the arrays of the kinds that are made here, its views unused */
  double *W;    /* W dense */
} regret_problem;

/* Makes a problem of about `size` contacts. Returns 0, or -1 for an unknown kind or without memory.
 * The kinds are those of tests/shared/rigid.h and
 *
 *   elastic2, elastic3       two elastic bodies, pressed together and along, W dense;
 *                            elastic2-blocks, elastic3-blocks: with all blocks of W stored
 *   ell3-rest, ell3-flow     balls-rest, balls-flow with normals tilted by .3 and three unequal
 *                            inertias: ellipsoids
 *   poly2-rest, poly2-flow   discs that touch in two points each: polygons, normals tilted by .1
 *   poly3-flow               balls that touch in three points each: polyhedra
 *   drum2, drum3             settled discs, balls on a floor that moves; smooth walls
 *   impact2, impact3         settled discs, balls, of which one in ten is fast
 *   gears                    2D wheels on heavy axles, in a grid; two flanks drive, one is behind
 *   dome                     3D voussoirs in rings, four contacts a face
 *   pyramid                  3D crates, each on four others, three contacts with each
 *   wedges                   2D keystones between blocks on a floor, driven in
 *   ill2, ill3               dense W with eigenvalues from 1 to 1e-4; the answer is planted
 *   bonded2, bonded3         the same from 1 to 1e-2; mu = INFINITY for half of the contacts
 *   rough3                   elastic half-space under a rough rigid stamp, dense
 *   cube.49, cube.4999       cubes of solvers_scenes.c with this ratio of Poisson: 49 to 169
 *   block2                   2D blocks of solvers_scenes.c, of the nearest size there
 *   train                    2D gears in a row, driven at both ends
 *   books                    3D a row of books, pressed together and lifted
 *   logs                     2D logs in a stack between two posts
 *   box, feet                3D one body, a robot of 18 or 30 motions on its feet: dense, that rank
 *   hand                     3D a body among finger tips that give
 *   beams, beams-pushed      3D beams in layers of three, crosswise, some missing; pushed along
 *   pyramid-pushed           pyramid, pushed ten times as much
 *   dominoes                 2D slabs that lean on each other in a row
 *   worn3-rest               ell3-rest with a tilt of .1
 *   drum3-sizes              drum3 with radii from 1 to 10
 *   asperities               elastic half-space under points of random places and heights, dense
 *   cloth, cloth-stiff, rope, plates   nets of springs (regret_nets.c), dense */
int regret_create(regret_problem *a, const char *kind, int size, double mu, uint64_t seed);
void regret_free(regret_problem *a);

/* The kinds; NULL past the last. The first regret_listed are those of rigid.h but for the sizes,
 * and the pairs of elastic bodies. */
enum { regret_listed = 24 };
const char *regret_kind(int index);

/* Returns 1 for a pair of elastic bodies, which has at most regret_most_of_pair contacts. */
enum { regret_most_of_pair = 2000 };
int regret_is_pair(const char *kind);

/* Returns the largest size that makes sense for a kind: dense W grow with its square. */
int regret_most(const char *kind);

/* Returns the state of bench_draw for a seed; neighbouring seeds give unrelated numbers, which a
 * multiple of the seed does not. salt: one for each use. */
uint64_t regret_state(uint64_t seed, uint64_t salt);

/* ---- the generators, each for the kinds of its file ------------------------------------------ */

/* regret_bodies.c: gears, dome, pyramid, wedges, train, books, logs, beams, dominoes. */
int regret_bodies(regret_problem *a, const char *kind, int size, double mu, uint64_t seed);

/* regret_grains.c: ell3-rest to impact3, worn3-rest, drum3-sizes. */
int regret_grains(regret_problem *a, const char *kind, int size, double mu, uint64_t seed);

/* regret_elastic.c: elastic2 to elastic3-blocks, ill2 to block2, box, feet, hand, asperities. */
int regret_elastic(regret_problem *a, const char *kind, int size, double mu, uint64_t seed);

/* regret_nets.c: cloth, cloth-stiff, rope, plates. */
int regret_nets(regret_problem *a, const char *kind, int size, double mu, uint64_t seed);

/* Allocates W, q, mu of a problem with dense W, all 0. Returns -1 without memory. */
int regret_room(regret_problem *a, int d, int nc);

/* W = H^T H, q += H^T v. H: n x m. */
void regret_multiply(regret_problem *a, int n, int m, const double *H, const double *v);

/* What is hard in a planted problem. rank: half of the eigenvalues are 0, r is not determined, u
 * is. border, d = 3: contacts in thirds: r = 0 and u = 0; |r_t| = mu r_n and u = 0; stick. bonded:
 * mu = INFINITY for every second contact. */
typedef enum planted_flaw { FLAW_NONE, FLAW_RANK, FLAW_BORDER, FLAW_BONDED, FLAWS } planted_flaw;

/* Makes a problem with a known answer: W = Q diag(eigenvalues) Q^T, Q from 30 reflections,
 * eigenvalues from 1 to 1 / condition, spaced evenly in their logarithm; r and u that obey the laws
 * are drawn first, free, stick or slip, one in three each, and q = u - W r. Returns 0, or -1. */
int regret_planted(regret_problem *a, int d, int nc, double condition, double mu, planted_flaw flaw,
                   uint64_t *state);

#endif
