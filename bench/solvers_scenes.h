/* solvers_scenes.h: contact problems of elastic blocks, walls and FCLIB files. */
#ifndef SOLVERS_SCENES_H
#define SOLVERS_SCENES_H

#include "delassus.h"

/* A contact problem; one reduced from a global problem comes with that. */
typedef struct scene {
  const char *set; /* "fclib", "global", "block", "cube", "wall" */
  char name[64];
  dls_contact contact;
  const dls_model *model; /* NULL for a local problem */
  const double *f, *g;    /* of the model */
} scene;

/* Called for each scene, which lives until the call returns. */
typedef void (*scene_fn)(void *data, const scene *s);

/* Visits the scenes of a set: sizes and friction coefficients of the quick run, or all. Returns 0,
 * or -1 after a message on stderr. */
int scenes_files(const char *directory, scene_fn visit, void *data);
int scenes_blocks(int full, scene_fn visit, void *data);
int scenes_cubes(int full, scene_fn visit, void *data);
int scenes_walls(int full, scene_fn visit, void *data);

/* Visits 48 cubes of this ratio of Poisson, with 49 to 169 candidates and frictions drawn from 0.3
 * to 4. Returns as the others do. */
int scenes_cubes_of(double nu, unsigned seed, scene_fn visit, void *data);

/* Visits random problem k: d = 1 + k % 3, W = A A^T / m + shift I with shift 0.1 or 0.001, entries
 * of A drawn; nc contacts, or nc = 0: drawn, 1 to `rows` rows.
 * Even seeds. Returns as the others do. */
int scenes_random(int k, int nc, int rows, scene_fn visit, void *data);

#endif
