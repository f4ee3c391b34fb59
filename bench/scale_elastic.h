/* scale_elastic.h: contact problems of two elastic bodies. */
#ifndef SCALE_ELASTIC_H
#define SCALE_ELASTIC_H

#include <stdint.h>

#include "delassus.h"

typedef struct elastic {
  dls_contact contact; /* of the arrays below */
  double *W, *q, *mu;
  int *p, *i; /* W by blocks */
  double *x;
} elastic;

/* Makes a problem of about `candidates` candidates. Returns 0, or -1 for an unknown kind, without
 * memory, or for more than elastic_most of them. Kinds: elastic2, elastic3 in 2D and 3D, W dense;
 * elastic2-blocks, elastic3-blocks: the same with all blocks of W stored. */
enum { elastic_most = 2000 };
int elastic_create(elastic *a, const char *kind, int candidates, double mu, uint64_t seed);
void elastic_free(elastic *a);

/* The kinds above, in that order; NULL past the last. */
const char *elastic_kind(int index);

#endif
