/* motion_peer.c: a solve by CHOLMOD. */
#include "motion_peer.h"

#include <stdlib.h>

#include "cholmod_view.h"
#include "common.h"

struct peer {
  cholmod_common c;
  cholmod_factor *L;
  cholmod_dense *X, *Y, *E;
};

peer *peer_create(const dls_sparse *K, int supernodal, double *seconds) {
  peer *p = calloc(1, sizeof *p);
  if (!p) return NULL;
  cholmod_sparse A = cholmod_view(K);
  cholmod_start(&p->c);
  p->c.supernodal = supernodal ? CHOLMOD_SUPERNODAL : CHOLMOD_SIMPLICIAL;
  const double start = bench_seconds();
  p->L = cholmod_analyze(&A, &p->c);
  const int ok = p->L && cholmod_factorize(&A, p->L, &p->c) && p->c.status == CHOLMOD_OK;
  *seconds = bench_seconds() - start;
  if (ok) return p;
  peer_destroy(p);
  return NULL;
}

const double *peer_solve(peer *p, const double *b) {
  cholmod_dense B = {.nrow = p->L->n,
                     .ncol = 1,
                     .nzmax = p->L->n,
                     .d = p->L->n,
                     .x = (void *)(size_t)b,
                     .xtype = CHOLMOD_REAL,
                     .dtype = CHOLMOD_DOUBLE};
  if (!cholmod_solve2(CHOLMOD_A, p->L, &B, NULL, &p->X, NULL, &p->Y, &p->E, &p->c)) return NULL;
  return p->X->x;
}

void peer_destroy(peer *p) {
  if (!p) return;
  cholmod_free_dense(&p->X, &p->c);
  cholmod_free_dense(&p->Y, &p->c);
  cholmod_free_dense(&p->E, &p->c);
  cholmod_free_factor(&p->L, &p->c);
  cholmod_finish(&p->c);
  free(p);
}
