/*
 * identify.c: finds the friction and the load of the block of Jean (1988), Fig. 3, from measured
 * displacements of its top edge. The measurement is a solve with mu = 0.8 and the side traction of
 * the paper, rounded to 1e-7 m as a gauge would do. Gauss-Newton steps from mu = 0.4 and half of
 * the traction: dls_derive_jvp gives the derivatives of the displacements, two solves with one
 * factorisation. At a kink, where a contact is between two states, one side's derivative serves.
 *
 * Output:
 *   0: mu = 0.400, load = 0.500, apart by 1.5e-05 m
 *   1: mu = 0.749, load = 1.014, apart by 3.8e-07 m
 *   2: mu = 0.790, load = 1.000, apart by 3.0e-08 m
 *   3: mu = 0.801, load = 1.000, apart by 2.6e-08 m
 *   4: mu = 0.801, load = 1.000, apart by 2.6e-08 m
 */
#include <delassus.h>
#include <delassus/fe.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { nx = 16, ny = 8, most = 2 * (nx + 1) * (ny + 1), line = 2 * (nx + 1) };

static dls_error error;
static dls_reduction *reduction;
static dls_fe_scene *scene;
static dls_fe_scene_data data;
static double f_top[most], f_side[most]; /* loads of the model: all = f_top + load f_side */

static void check(dls_status status) {
  if (status >= 0) return;
  fprintf(stderr, "%s\n", error.message);
  exit(1);
}

/* f := the loads of pressure on top and traction on the side, as the scene has them. */
static void loads(double top, double side, double side_top, double *f) {
  dls_fe_scene_settings s;
  dls_fe_scene *with;
  dls_fe_scene_data of;
  dls_fe_scene_settings_init(&s);
  s.has_load = 1;
  s.top = top;
  s.side = side;
  s.side_top = side_top;
  check(dls_fe_scene_create_with(&with, "jean-fig3", 0, &s, &error));
  dls_fe_scene_get(with, &of);
  memcpy(f, of.f, (size_t)of.model.n * sizeof *f);
  dls_fe_scene_destroy(with);
}

/* top (line) := the part of the model's x (or of its change) on the top edge. */
static void gauge(const double *x, double *top) {
  double all[most];
  check(dls_fe_scene_displacement(scene, x, all, &error));
  memcpy(top, all + most - line, line * sizeof *top);
}

/* Solves for mu and the load; u_mu, u_load (or NULL): the derivatives of the gauges. */
static void displace(double mu, double load, double *u, double *u_mu, double *u_load) {
  double f[most], friction[nx], ones[nx], r[2 * nx], x[most], dx[most];
  dls_derive *derive;
  for (int k = 0; k < data.model.n; k++)
    f[k] = f_top[k] + load * f_side[k];
  for (int c = 0; c < nx; c++) {
    friction[c] = mu;
    ones[c] = 1;
  }
  check(dls_reduction_load(reduction, f, NULL, &error));
  check(dls_reduction_solve(reduction, friction, NULL, r, NULL, x, NULL, &error));
  gauge(x, u);
  if (!u_mu) return;
  dls_status status = dls_derive_create_body(&derive, reduction, friction, r, x, -1, &error);
  if (status == DLS_E_NO_DERIVATIVE)
    status = dls_derive_create_body(&derive, reduction, friction, r, x, 0, &error);
  check(status);
  const dls_derive_answer change = {.x = dx};
  check(dls_derive_jvp(derive, &(dls_derive_data){.mu = ones}, &change, &error));
  gauge(dx, u_mu);
  check(dls_derive_jvp(derive, &(dls_derive_data){.f = f_side}, &change, &error));
  gauge(dx, u_load);
  dls_derive_destroy(derive);
}

int main(void) {
  double measured[line], u[line], a[line], b[line], mu = 0.4, load = 0.5;
  check(dls_fe_scene_create(&scene, "jean-fig3", 0, &error));
  dls_fe_scene_get(scene, &data);
  check(dls_reduction_create(&reduction, &data.model, NULL, &error));
  loads(5e8, 0, 0, f_top);
  loads(0, 9e8, 25e8, f_side);
  displace(0.8, 1, measured, NULL, NULL);
  for (int k = 0; k < line; k++)
    measured[k] = 1e-7 * round(measured[k] / 1e-7);
  for (int step = 0; step < 5; step++) {
    double aa = 0, ab = 0, bb = 0, ae = 0, be = 0, ee = 0;
    displace(mu, load, u, a, b);
    for (int k = 0; k < line; k++) {
      const double e = measured[k] - u[k];
      aa += a[k] * a[k];
      ab += a[k] * b[k];
      bb += b[k] * b[k];
      ae += a[k] * e;
      be += b[k] * e;
      ee += e * e;
    }
    printf("%d: mu = %.3f, load = %.3f, apart by %.1e m\n", step, mu, load, sqrt(ee / line));
    const double det = aa * bb - ab * ab;
    mu = fmax(mu + (bb * ae - ab * be) / det, mu / 2); /* not below 0 */
    load += (aa * be - ab * ae) / det;
  }
  dls_reduction_destroy(reduction);
  dls_fe_scene_destroy(scene);
  return 0;
}
