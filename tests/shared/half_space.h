/* half_space.h: W dense of the surface of an elastic half-plane and half-space. */
#ifndef HALF_SPACE_H
#define HALF_SPACE_H

#include "delassus/contact.h"

/* Makes the surface of an elastic half-plane: nc cells of width h = 2 / nc, by Flamant's solution,
 * in units of 2 (1 - nu^2) / (pi E). Along a line force W is the mean of -log |x| over the cell,
 * plus `depth` for where the body is held; across it pi / 2 (1 - 2 nu) / (2 - 2 nu), nu = 1 / 8.
 * u_t is pushed by `push`; q_n = -1 + crown x^2. W (m x m), q (m), mu (nc): storage, m = 2 nc. */
dls_contact half_plane(double *W, double *q, double *mu, int nc, double depth, double push,
                       double crown, double friction);

/* W (3 nc square) := that of nc points (x, y) of a half-space, G = 1, nu = .3, each with itself by
 * the mean over a square of side a: Boussinesq's and Cerruti's solutions. at: 2 nc. */
void half_space(int nc, const double *at, double a, double *W);

#endif
