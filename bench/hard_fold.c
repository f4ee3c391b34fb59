/*
 * hard_fold.c: brackets the fold in 3D, the least friction at which some loads have two answers.
 * src/facts/fold.c finds it for d = 2 alone: in 3D the direction of slip turns with the motion.
 *
 *   below   friction_unique of delassus/diagnose.h: one answer for every q, proved up to rounding
 *   above   the least friction at which two answers of one q were found, both certified at 1e-10
 *
 * Candidates for a pair: a direction e_c is drawn for each contact, and W projected on (n, e_c) is
 * a problem with d = 2, of which dls_contact_fold gives the states at its fold. These states are
 * planted in 3D above that friction: r of the witness along e_c; u_t = -L e_c where it slips, L
 * large, so that the direction of slip hardly turns; q = u - W r. In that state the determinant has
 * changed its sign, so that other answers are expected; methods and starts look for them.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "delassus/diagnose.h"
#include "delassus/trust.h"
#include "hard.h"

enum { most_contacts = 6, rows = 3 * most_contacts, draws = 40, starts = 12, tried = 4 };

static const double certified = 1e-10, apart = 1e-3, far = 1e3 /* L over W r */;
static const double above[tried] = {1.02, 1.1, 1.3, 2}; /* of the fold of the projection */

typedef struct fold_pair {
  double friction, distance;
  int proved; /* of both answers */
} fold_pair;

/* W2 (2 nc x 2 nc) := W projected on (n, e_c); e: 2 nc. */
static void fold_project(const dls_contact *p, const double *e, double *W2) {
  const int m = 3 * p->nc, n = 2 * p->nc;
  for (int j = 0; j < n; j++)
    for (int i = 0; i < n; i++) {
      double sum = 0;
      for (int b = 0; b < 3; b++)
        for (int a = 0; a < 3; a++) {
          const double left = i % 2 == 0 ? a == 0 : a ? e[2 * (i / 2) + a - 1] : 0;
          const double right = j % 2 == 0 ? b == 0 : b ? e[2 * (j / 2) + b - 1] : 0;
          sum += left * p->W.a[(3 * (i / 2) + a) + m * (3 * (j / 2) + b)] * right;
        }
      W2[i + n * j] = sum;
    }
}

/* Plants the states of the fold in 3D with the friction mu: r, and q of *p. */
static void fold_plant(dls_contact *p, const double *e, const dls_contact_state *state,
                       const double *r2, double mu, double *r, double *q) {
  const int m = 3 * p->nc;
  double size = 0;
  for (int c = 0; c < p->nc; c++) {
    const double side = r2[2 * c + 1] < 0 ? -1 : 1;
    r[3 * c] = state[c] == DLS_FREE ? 0 : r2[2 * c];
    for (int a = 0; a < 2; a++)
      r[3 * c + 1 + a] = state[c] == DLS_FREE   ? 0
                         : state[c] == DLS_SLIP ? side * mu * r[3 * c] * e[2 * c + a]
                                                : r2[2 * c + 1] * e[2 * c + a];
  }
  for (int i = 0; i < m; i++) {
    q[i] = 0;
    for (int j = 0; j < m; j++)
      q[i] -= p->W.a[i + m * j] * r[j];
    size = fmax(size, fabs(q[i]));
  }
  for (int c = 0; c < p->nc; c++) {
    const double side = r2[2 * c + 1] < 0 ? -1 : 1;
    if (state[c] == DLS_FREE) q[3 * c] += size;
    for (int a = 0; a < 2 && state[c] == DLS_SLIP; a++)
      q[3 * c + 1 + a] -= side * far * size * e[2 * c + a];
  }
}

/* Looks for another answer than r; returns 1 and fills *pair if there is one. */
static int fold_look(const dls_contact *p, const double *r, uint64_t *state, fold_pair *pair) {
  static const dls_method methods[] = {DLS_AUTO, DLS_NEWTON, DLS_NLGS, DLS_AUGMENTED_LAGRANGIAN,
                                       DLS_HOMOTOPY};
  const int m = 3 * p->nc;
  double size = 0, other[rows];
  for (int i = 0; i < m; i++)
    size = fmax(size, fabs(r[i]));
  for (int s = 0; s < starts; s++)
    for (int k = 0; k < 5; k++) {
      dls_solver_settings settings;
      dls_solver_settings_init(&settings);
      settings.method = methods[k];
      settings.limits.tol = certified;
      settings.limits.warm_start = s > 0;
      settings.limits.max_iterations = 2000;
      for (int i = 0; i < m; i++)
        other[i] = size * (bench_draw(state) + (i % 3 == 0));
      dls_certificate c = {0};
      if (dls_solve(p, &settings, other, NULL, NULL, NULL) < 0 ||
          dls_contact_certify(p, other, NULL, &c, NULL) || !dls_certificate_holds(&c, certified))
        continue;
      double distance = 0;
      for (int i = 0; i < m; i++)
        distance = fmax(distance, fabs(other[i] - r[i]) / size);
      if (!(distance > apart)) continue;
      dls_proof proof = {0};
      pair->distance = distance;
      pair->proved =
          dls_contact_prove(p, r, &proof, NULL, NULL) == DLS_OK && proof.kind == DLS_PROVED;
      if (pair->proved)
        pair->proved =
            dls_contact_prove(p, other, &proof, NULL, NULL) == DLS_OK && proof.kind == DLS_PROVED;
      return 1;
    }
  return 0;
}

/* Draws directions and looks for a pair below pair->friction. */
static void fold_draw(const hard_problem *h, uint64_t *draw, double *projected, fold_pair *pair) {
  const int nc = h->contact.nc;
  double W2[4 * most_contacts * most_contacts], zero[2 * most_contacts] = {0}, e[2 * most_contacts];
  double one[most_contacts], r2[2 * most_contacts], r[rows], q[rows], mu[most_contacts];
  dls_contact_state state[most_contacts];
  const double common = 3.14159265358979 * bench_draw(draw);
  const double spread = bench_draw(draw) > 0 ? 3.14159265358979 : 0.3;
  for (int c = 0; c < nc; c++) {
    const double angle = common + spread * bench_draw(draw);
    e[2 * c] = cos(angle);
    e[2 * c + 1] = sin(angle);
    one[c] = 1;
  }
  fold_project(&h->contact, e, W2);
  const dls_contact flat = {
      .d = 2, .nc = nc, .W = {2 * nc, 2 * nc, 2 * nc, W2}, .q = zero, .mu = one};
  dls_fold fold = {0};
  if (dls_contact_fold(&flat, &fold, state, NULL, r2, NULL, NULL) || !isfinite(fold.friction))
    return;
  *projected = fmin(*projected, fold.friction);
  for (int k = 0; k < tried && above[k] * fold.friction < pair->friction; k++) {
    dls_contact p = h->contact;
    p.q = q;
    p.mu = mu;
    for (int c = 0; c < nc; c++)
      mu[c] = above[k] * fold.friction;
    fold_plant(&p, e, state, r2, mu[0], r, q);
    dls_certificate c = {0};
    if (dls_contact_certify(&p, r, NULL, &c, NULL) || !dls_certificate_holds(&c, certified))
      continue;
    if (!fold_look(&p, r, draw, pair)) continue;
    pair->friction = mu[0];
    return;
  }
}

int hard_fold_table(FILE *page, const char *out) {
  FILE *csv = bench_open(out, "hard_fold.csv");
  double least = INFINITY, most = 0;
  if (!csv) return 1;
  fprintf(csv, "contacts,condition,seed,below,projected,above,distance,proved\n");
  bench_print(page,
              "| contacts | condition | seed | one answer below | fold of a projection | two "
              "answers at | their distance | both proved |\n|---|---|---|---|---|---|---|---|\n");
  for (int nc = 2; nc <= most_contacts; nc += 2)
    for (double condition = 10; condition < 2e4; condition *= condition)
      for (uint64_t seed = 2; seed <= 4; seed += 2) {
        hard_problem h;
        if (hard_create(&h, nc, condition, 0, HARD_NONE, seed)) return 1;
        dls_diagnosis d = {0};
        if (dls_contact_diagnose(&h.contact, rows, &d, NULL)) return 1;
        fold_pair pair = {.friction = INFINITY};
        double projected = INFINITY;
        uint64_t draw = seed;
        for (int k = 0; k < draws; k++)
          fold_draw(&h, &draw, &projected, &pair);
        fprintf(csv, "%d,%g,%d,%g,%g,%g,%g,%d\n", nc, condition, (int)seed, d.friction_unique,
                projected, pair.friction, pair.distance, pair.proved);
        least = fmin(least, pair.friction / d.friction_unique);
        most = fmax(most, pair.friction / d.friction_unique);
        bench_print(seed > 2 ? NULL : page, "| %d | %.0e | %d | %.3g | %.3g | %.3g | %.1e | %s |\n",
                    nc, condition, (int)seed, d.friction_unique, projected, pair.friction,
                    pair.distance,
                    isinf(pair.friction) ? "-"
                    : pair.proved        ? "yes"
                                         : "no");
        hard_free(&h);
      }
  bench_print(
      page,
      "\nWith seed 4, too: two answers at %.2g to %.2g times the friction below which there "
      "is one.\n",
      least, most);
  return fclose(csv) != 0;
}
