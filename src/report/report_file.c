/*
 * report_file.c: the error budget of a contact problem that has no mesh: tolerance, friction, and
 * what the answer is proved to (report.h).
 *
 * The reference is the answer to the tightest tolerance, improved and proved where
 * dls_contact_prove can. Errors are of the reactions, or of the positions over q where W does not
 * determine the reactions.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "report.h"

enum { REPEATS = 5, MOST_SHOWN = 40 };  /* contacts in a table */
enum { most_rows_of_proof = 600 };      /* takes a second there */
static const double short_solve = 0.01; /* CPU seconds: a shorter solve is timed again */
static const double solve_share = 0.05; /* of the CPU limit: a solve */

/* Solves by auto to tol: r (m), *info, *seconds. */
static dls_status solve_to(const dls_contact *contact, double tol, double limit, double *r,
                           double *u, dls_info *info, double *seconds, dls_error *error) {
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  s.limits.tol = tol;
  s.limits.cpu_seconds = limit;
  s.limits.progress = show_progress;
  dls_status status = DLS_OK;
  double all = 0;
  *seconds = INFINITY;
  for (int k = 0; k < REPEATS && status >= 0 && all < short_solve; k++) {
    const double start = cpu_seconds();
    status = dls_solve(contact, &s, r, u, info, error);
    const double one = cpu_seconds() - start;
    *seconds = fmin(*seconds, one);
    all += one;
  }
  progress_end();
  return status < 0 ? status : DLS_OK;
}

/* Solves every rung and finds the tightest that is solved. */
static dls_status solve_rungs(file_budget *b, dls_error *error) {
  const size_t m = (size_t)b->contact->d * (size_t)b->contact->nc;
  const double start = cpu_seconds();
  dls_status status = DLS_OK;
  b->best = -1;
  for (int k = 0; k < FILE_RUNGS && !status; k++) {
    b->tol[k] = pow(10, -1 - k);
    b->error[k] = NAN;
    b->info[k].status = DLS_TIME_LIMIT;
    if (cpu_seconds() - start > b->limit / 2 || was_interrupted()) continue;
    status = solve_to(b->contact, b->tol[k], solve_share * b->limit, b->answer + (size_t)k * m,
                      b->u, &b->info[k], &b->seconds[k], error);
    if (!status && dls_solved(b->info[k].status)) b->best = k;
  }
  return status;
}

/* Makes the reference from the best answer; *scale: of errors. */
static dls_status make_reference(file_budget *b, double *scale, dls_error *error) {
  const size_t m = (size_t)b->contact->d * (size_t)b->contact->nc;
  dls_certificate certificate;
  dls_status status = DLS_OK;
  memcpy(b->r, b->answer + (size_t)b->best * m, m * sizeof *b->r);
  if (m <= most_rows_of_proof) status = dls_contact_prove(b->contact, b->r, &b->proof, b->r, error);
  if (!status) status = dls_contact_certify(b->contact, b->r, b->u, &certificate, error);
  if (!status) status = dls_contact_states(b->contact, b->r, b->u, b->state, error);
  b->in_u = b->proof.freedom > 0 || b->info[b->best].error > 1; /* INFINITY: r is not determined */
  *scale = distance(m, b->in_u ? b->contact->q : b->r, NULL);
  if (!(*scale > 0)) *scale = 1;
  return status;
}

/* Measures the errors of the rungs, and chooses. */
static dls_status measure_rungs(file_budget *b, dls_error *error) {
  const size_t m = (size_t)b->contact->d * (size_t)b->contact->nc;
  double scale;
  dls_status status = make_reference(b, &scale, error);
  const double radius = !b->proof.kind ? 0 : b->in_u ? b->proof.radius_u : b->proof.radius;
  int good = 1;
  b->take = -1;
  for (int k = FILE_RUNGS - 1; k >= 0 && !status; k--) {
    double *x = b->answer + (size_t)k * m;
    dls_certificate certificate;
    if (!dls_solved(b->info[k].status)) continue;
    if (b->in_u) {
      status = dls_contact_certify(b->contact, x, b->other, &certificate, error);
      memcpy(x, b->other, m * sizeof *x);
    }
    b->error[k] = distance(m, x, b->in_u ? b->u : b->r) / scale + radius;
    good = good && b->error[k] <= b->accuracy; /* and all that are tighter */
    if (good) b->take = k;
  }
  return status;
}

/* Solves without friction. */
static dls_status leave_friction(file_budget *b, dls_error *error) {
  const size_t m = (size_t)b->contact->d * (size_t)b->contact->nc;
  dls_contact contact = *b->contact;
  double *zero = calloc((size_t)contact.nc + 2 * m, sizeof *zero);
  double seconds;
  dls_info info;
  dls_certificate certificate;
  if (!zero) return DLS_E_MEMORY;
  const int has_friction = largest_entry(contact.mu, contact.nc) > 0;
  contact.mu = zero;
  double *r = zero + contact.nc, *u = r + m;
  dls_status status = DLS_OK;
  if (has_friction)
    status = solve_to(&contact, 1e-8, solve_share * b->limit, r, u, &info, &seconds, error);
  if (!status && has_friction && dls_solved(info.status)) {
    status = dls_contact_certify(&contact, r, u, &certificate, error);
    const double scale = distance(m, b->in_u ? b->contact->q : b->r, NULL);
    b->no_friction = distance(m, b->in_u ? u : r, b->in_u ? b->u : b->r) / (scale > 0 ? scale : 1);
  }
  free(zero);
  return status;
}

dls_status file_budget_run(file_budget *b, dls_error *error) {
  const size_t m = (size_t)b->contact->d * (size_t)b->contact->nc;
  const size_t nc = (size_t)b->contact->nc;
  b->take = b->best = -1;
  b->no_friction = NAN;
  b->answer = malloc((FILE_RUNGS + 3) * (m + 1) * sizeof *b->answer);
  b->state = malloc((nc + 1) * sizeof *b->state);
  if (!b->answer || !b->state) return no_memory(error);
  b->r = b->answer + FILE_RUNGS * m;
  b->u = b->r + m;
  b->other = b->u + m;
  dls_status status = solve_rungs(b, error);
  if (!status && b->best >= 0) status = measure_rungs(b, error);
  if (!status && b->best >= 0) status = leave_friction(b, error);
  return status;
}

void file_budget_free(file_budget *b) {
  free(b->answer);
  free(b->state);
}

/* ---- words ----------------------------------------------------------------------------------- */

void file_verdict(const file_budget *b, char *text, size_t size) {
  const char *what = b->in_u ? "positions" : "reactions";
  const int k = b->take;
  char error[24], wanted[24];
  (void)percent(b->accuracy, wanted);
  if (b->best < 0) {
    verdict v = {0};
    const dls_status status = b->info[FILE_RUNGS - 1].status;
    verdict_fill(&v, status, 0);
    const char *next = v.next ? v.next : "";
    (void)snprintf(text, size, "Not solved by auto: %s%s%.*s", dls_status_text(status),
                   v.next ? ". " : "", (int)strlen(next) - (*next != '\0'), next);
  } else if (k < 0) {
    (void)snprintf(text, size,
                   "Not decided: no tolerance is within %s. The best, tol %.0e: %s within %s",
                   wanted, b->tol[b->best], what, percent(b->error[b->best], error));
  } else {
    (void)snprintf(text, size, "Take auto, tol %.0e: %s within %s, %s of CPU (%s: %s)", b->tol[k],
                   what, wanted, in_words(b->seconds[k]).text,
                   b->proof.kind ? "proved" : "measured", percent(b->error[k], error));
  }
}

void file_tables(const file_budget *b, page *p) {
  char words[120], moved[24];
  page_say(p, PAGE_PLAIN,
           "A file has no mesh. The answer is all %s; errors are relative to the answer to the "
           "tightest tolerance: %s.",
           b->in_u ? "positions, for W does not determine the reactions" : "reactions",
           b->best < 0 ? "there is none" : proof_words(&b->proof, words, sizeof words));
  page_table(p, "changed,verdict,iterations,residual,error,CPU");
  for (int k = 0; k < FILE_RUNGS; k++) {
    const dls_info *i = &b->info[k];
    page_cell(p, "tolerance %.0e%s", b->tol[k], k == b->take ? " (take)" : "");
    page_cell(p, "%s", ending_word(ending_of(i->status)));
    page_cell(p, "%d", i->iterations);
    page_cell(p, "%.2g", i->certificate.residual);
    page_cell(p, isfinite(b->error[k]) ? "%.2g" : "", b->error[k]);
    page_cell(p, "%s", in_words(b->seconds[k]).text);
  }
  page_table_end(p);
  if (isfinite(b->no_friction))
    page_say(p, PAGE_PLAIN, "Without friction the answer moves by %s.",
             percent(b->no_friction, moved));
}

void file_contacts(const file_budget *b, page *p) {
  static const char *const heads[] = {"contact,state,r_n,u_n", "contact,state,r_n,r_t,u_n,u_t",
                                      "contact,state,r_n,r_t,r_s,u_n,u_t,u_s"};
  const int d = b->contact->d, nc = b->contact->nc;
  int count[3] = {0};
  if (b->best < 0) {
    page_say(p, PAGE_PLAIN, "There is no answer.");
    return;
  }
  for (int c = 0; c < nc; c++)
    count[b->state[c]]++;
  page_say(p, PAGE_PLAIN, "%d contact%s: %d free, %d slip, %d stick.", nc, plural(nc),
           count[DLS_FREE], count[DLS_SLIP], count[DLS_STICK]);
  page_table(p, heads[d - 1]);
  for (int c = 0; c < nc && c < MOST_SHOWN; c++) {
    page_cell(p, "%d", c + 1);
    page_cell(p, "%s", state_word(b->state[c]));
    for (int i = 0; i < d; i++)
      page_cell(p, "%.4g", b->r[d * c + i]);
    for (int i = 0; i < d; i++)
      page_cell(p, "%.4g", b->u[d * c + i]);
  }
  page_table_end(p);
  if (nc > MOST_SHOWN) page_say(p, PAGE_NOTE, "The first %d of %d contacts.", MOST_SHOWN, nc);
}
