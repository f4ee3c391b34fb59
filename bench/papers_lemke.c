/*
 * papers_lemke.c: how does Lemke's method grow with the number of contacts? [Chabrand 1998] 6 finds
 * it "always the fastest", and expects that it fails "for very large numbers of degrees of
 * freedom".
 *
 *   blocks   jean-fig3 on nx x nx/2 rectangles, nx contacts, LCP of 3 nx rows
 *   lining   the flat elastic lining of lemke_problems.c, LCP of 3 nc rows
 *
 * path: the paper's pivots alone. crash: many pairs at once first (the default of lcp.h). The
 * condensation K -> W is not counted.
 */
#include <math.h>
#include <stdlib.h>

#include "common.h"
#include "lemke.h"
#include "papers.h"

enum { kinds = 2, most_sizes = 7 };

static const char *const kind_name[kinds] = {"block", "lining"};
static const int sizes[kinds] = {6, 7}, first[kinds] = {8, 16};

typedef struct lemke_row {
  double n, pivots[2], cpu[2], residual[2]; /* path, crash */
  double by_auto;                           /* CPU seconds of auto to 1e-8 */
  int solved[2];
} lemke_row;

/* Solves the LCP once more than needed where a solve is short; counts the shortest. */
static int lemke_measure(const dls_lcp *lcp, lemke_row *row) {
  double *z = calloc((size_t)lcp->n, sizeof *z);
  if (!z) return -1;
  row->n = lcp->n;
  for (int crash = 0; crash < 2; crash++) {
    dls_lemke_settings s;
    dls_lemke_settings_init(&s);
    s.crash = crash;
    bench_clock c = {0};
    while (bench_runs(&c, 1, 3, 1)) {
      dls_lemke *work = NULL;
      dls_lemke_info info = {0};
      dls_status status = dls_lemke_create(&work, lcp->n, &s, NULL);
      if (!status) status = dls_lemke_solve(work, lcp, z, NULL, &info, NULL);
      dls_lemke_destroy(work);
      row->pivots[crash] = info.pivots + info.crash_rounds;
      row->residual[crash] = info.certificate.residual;
      row->solved[crash] = status == DLS_OK;
    }
    row->cpu[crash] = c.least;
  }
  free(z);
  return 0;
}

/* Copies the problem in units in which the largest entries of W and q are 1: an LCP mixes forces
 * and lengths in its unknowns. */
static int lemke_scale(const dls_contact *contact, lining *l) {
  const size_t m = 2 * (size_t)contact->nc, ld = (size_t)contact->W.ld;
  double of_W = 0, of_q = 0;
  l->W = calloc(m * m, sizeof *l->W);
  l->q = calloc(m, sizeof *l->q);
  if (!l->W || !l->q) return -1;
  for (size_t j = 0; j < m; j++) {
    of_q = fmax(of_q, fabs(contact->q[j]));
    for (size_t i = 0; i < m; i++)
      of_W = fmax(of_W, fabs(contact->W.a[i + j * ld]));
  }
  for (size_t j = 0; j < m; j++) {
    l->q[j] = contact->q[j] / of_q;
    for (size_t i = 0; i < m; i++)
      l->W[i + j * m] = contact->W.a[i + j * ld] / of_W;
  }
  l->contact = *contact;
  l->contact.W = (dls_dense){(int)m, (int)m, (int)m, l->W};
  l->contact.q = l->q;
  return 0;
}

/* Sets the CPU seconds of auto on the contact problem, the shortest of three. */
static int lemke_auto(const dls_contact *contact, lemke_row *row) {
  double *r = calloc(2 * (size_t)contact->nc, sizeof *r);
  dls_status status = r ? DLS_OK : DLS_E_MEMORY;
  bench_clock c = {0};
  while (!status && bench_runs(&c, 3, 0, 0))
    status = dls_solve(contact, NULL, r, NULL, NULL, NULL);
  row->by_auto = c.least;
  free(r);
  return status ? -1 : 0;
}

/* Makes the LCP of a kind and size, 3 rows a contact. */
static int lemke_problem(int kind, int nc, lemke_row *row) {
  problem p = {0};
  int bad;
  if (kind == 0) {
    jean_block b;
    if (jean_create(&b, "jean-fig3", 0, nc, -1)) return -1;
    lining l = {0};
    bad = lemke_scale(&b.contact, &l) || lemke_auto(&b.contact, row) || problem_from_lining(&p, &l);
    lining_free(&l);
    jean_free(&b);
  } else {
    lining l;
    bad = lining_create(&l, nc);
    if (!bad) bad = lemke_auto(&l.contact, row) || problem_from_lining(&p, &l);
    lining_free(&l);
  }
  if (bad) return -1;
  const dls_lcp lcp = problem_view(&p);
  bad = lemke_measure(&lcp, row);
  problem_free(&p);
  return bad;
}

int papers_lemke(FILE *page, const char *out) {
  FILE *csv = bench_open(out, "papers_lemke.csv");
  if (!csv) return 1;
  fprintf(csv, "kind,contacts,rows,path_pivots,path_s,crash_rounds,crash_s,auto_s\n");
  lemke_row row[kinds][most_sizes];
  double of_pivots[kinds], of_path[kinds], of_crash[kinds], of_auto[kinds];
  for (int kind = 0; kind < kinds; kind++) {
    double n[most_sizes], pivots[most_sizes], path[most_sizes], crash[most_sizes],
        by_auto[most_sizes];
    for (int k = 0; k < sizes[kind]; k++) {
      lemke_row *r = &row[kind][k];
      if (lemke_problem(kind, first[kind] << k, r)) return 1;
      n[k] = r->n;
      pivots[k] = r->pivots[0];
      path[k] = r->cpu[0];
      crash[k] = r->cpu[1];
      by_auto[k] = r->by_auto;
      fprintf(csv, "%s,%g,%g,%g,%g,%g,%g,%g\n", kind_name[kind], n[k] / 3, n[k], pivots[k], path[k],
              r->pivots[1], crash[k], by_auto[k]);
    }
    const size_t count = (size_t)sizes[kind];
    of_pivots[kind] = bench_exponent(count, n, pivots, 4);
    of_path[kind] = bench_exponent(count, n, path, 4);
    of_crash[kind] = bench_exponent(count, n, crash, 4);
    of_auto[kind] = bench_exponent(count, n, by_auto, 4);
  }
  if (fclose(csv)) return 1;
  const lemke_row *large = &row[1][sizes[1] - 1];
  bench_print(
      page,
      "## How does Lemke's method grow?\n\nThe pivots grow like n (exponents %.2f and %.2f), the "
      "CPU of the path like n^%.1f to n^%.1f, because each pivot\nchanges a table of n x (n + 1). "
      "It takes %.2g s for %g contacts, auto %.2g s. The path did not fail up to %g rows,\nthe "
      "largest here. The crash start pivots many pairs at once. It needs %g to %g rounds and is up "
      "to %.0f times faster.\nauto takes %.1f times the CPU of the crash start on the largest "
      "block, %.1f times on the largest lining.\n\nThe LCPs have 3 rows a contact, in units in "
      "which the largest entries of W and q are 1. Exponents: of the last four\nsizes. auto: the "
      "contact problem to 1e-8. Seconds are without the condensation K -> W.\n\n| problem | "
      "contacts | rows | path: pivots | s | residual | crash start: rounds | s | residual | auto: "
      "s |\n|---|---|---|---|---|---|---|---|---|---|\n",
      of_pivots[0], of_pivots[1], fmin(of_path[0], of_path[1]), fmax(of_path[0], of_path[1]),
      large->cpu[0], large->n / 3, large->by_auto, fmax(large->n, row[0][sizes[0] - 1].n),
      row[0][0].pivots[1], row[0][sizes[0] - 1].pivots[1], large->cpu[0] / large->cpu[1],
      row[0][sizes[0] - 1].by_auto / row[0][sizes[0] - 1].cpu[1], large->by_auto / large->cpu[1]);
  for (int kind = 0; kind < kinds; kind++) {
    for (int k = 0; k < sizes[kind]; k++) {
      const lemke_row *r = &row[kind][k];
      bench_print(k < sizes[kind] - 1 ? NULL : page,
                  "| %s | %g | %g | %g | %.2g | %s%.0e | %g | %.2g | %s%.0e | %.2g |\n",
                  kind_name[kind], r->n / 3, r->n, r->pivots[0], r->cpu[0],
                  r->solved[0] ? "" : "not solved, ", r->residual[0], r->pivots[1], r->cpu[1],
                  r->solved[1] ? "" : "not solved, ", r->residual[1], r->by_auto);
    }
    bench_print(page, "| %s, exponent of the last four | | | %.2f | %.2f | | | %.2f | | %.2f |\n",
                kind_name[kind], of_pivots[kind], of_path[kind], of_crash[kind], of_auto[kind]);
  }
  bench_print(page, "\n![Pivots and CPU against rows](papers_lemke.png)\n\n");
  return 0;
}
