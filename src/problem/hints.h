/* hints.h: what is plausible and wrong in the input of a solve; each prints a line on stderr or
 * nothing, and nothing with --quiet. */
#ifndef HINTS_H
#define HINTS_H

#include "problem.h"

/* Normals that have not length 1; tangents that are not perpendicular to them. Nothing where
 * unknowns may be rotations or forces of joints: K has a zero on its diagonal; or it couples no
 * unknown with more than the 3 (d - 1) of a rigid body, and n is a multiple of that. */
void hint_operators(const dls_model *model);

/* Returns 0 if an unknown may be a rotation or the force of a joint. */
int model_is_nodal(const dls_model *model);

/* All gaps negative. g: d nodes. */
void hint_gaps(const double *g, int d, int nodes);

/* Nothing presses though there are loads; H_N and H_T exchanged. r: of a solved problem. */
void hint_answer(const problem *p, const double *r);

/* Displacements (2 nodes) beyond the size of the body. */
void hint_size(const dls_fe_mesh *mesh, const double *displacement);

#endif
