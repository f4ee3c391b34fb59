/*
 * host_moving.c: contact that moves over a body that is factorised once. A strip of springs lies on
 * soft supports c; a wheel of weight 1, an unknown of its own, rolls over it, node by node. K is
 * condensed to the nodes that the wheel may touch, and dls_reduction_move takes each new contact.
 * Under the wheel a long strip sinks by 1 / sqrt(c (c + 4)).
 *
 * Output:
 *   the strip under the wheel sinks by 0.9701, by hand 0.9701; as new reductions say: yes
 */
#include <delassus.h>
#include <math.h>
#include <stdio.h>

enum { nodes = 60, n = nodes + 1, wheel = nodes, first = 20, last = 40 };

/* Contact of the wheel with a node: u_n = x_node - x_wheel, both down. */
static dls_model contact_with(int node, int *row) {
  static const int p[] = {0, 2}, none[] = {0, 0};
  static const double x[] = {1, -1};
  row[0] = node;
  row[1] = wheel;
  return (dls_model){
      .d = 2, .n = n, .nodes = 1, .HN = {n, 1, p, row, x}, .HT = {n, 1, none, row, x}};
}

int main(void) {
  int p[n + 1] = {0}, i[2 * n], row[2], surface[last - first + 2];
  double K[2 * n], f[n] = {0}, x[n], y[n], r[2], s[2];
  const double mu[] = {0}, c = 0.25;
  for (int j = 0, k = 0; j < n;
       p[++j] = k) { /* lower triangle: neighbours tied, a soft support each */
    i[k] = j;
    K[k++] = j == wheel ? 1e-6 : 2 + c;
    if (j < nodes - 1) i[k] = j + 1, K[k++] = -1;
  }
  f[wheel] = 1;
  for (int k = 0; k <= last - first; k++)
    surface[k] = first + k;
  surface[last - first + 1] = wheel;
  dls_error error;
  dls_reduction *moving = NULL, *again = NULL;
  dls_reduction_settings settings;
  dls_reduction_settings_init(&settings);
  settings.surface = surface;
  settings.surface_count = last - first + 2;
  double apart = 0, middle = 0;
  int status = DLS_OK;
  for (int node = first; node <= last && !status; node++) {
    dls_model model = contact_with(node, row);
    model.operator_kind = DLS_STIFFNESS_SPARSE;
    model.factorization = DLS_CHOLESKY;
    model.Ks = (dls_sparse){n, n, p, i, K};
    if (!moving) {
      status = dls_reduction_create(&moving, &model, &settings, &error);
      if (!status) status = dls_reduction_load(moving, f, NULL, &error);
    } else
      status = dls_reduction_move(moving, &model, NULL, &error);
    if (!status) status = dls_reduction_solve(moving, mu, NULL, r, NULL, x, NULL, &error);
    if (!status) status = dls_reduction_create(&again, &model, NULL, &error);
    if (!status) status = dls_reduction_load(again, f, NULL, &error);
    if (!status) status = dls_reduction_solve(again, mu, NULL, s, NULL, y, NULL, &error);
    for (int k = 0; k < n && !status; k++)
      apart = fmax(apart, fabs(x[k] - y[k]));
    if (node == nodes / 2) middle = x[node];
    dls_reduction_destroy(again);
    again = NULL;
  }
  dls_reduction_destroy(moving);
  if (status < 0) return fprintf(stderr, "%s\n", error.message);
  const double by_hand = 1 / sqrt(c * (c + 4));
  const int good = !status && apart <= 1e-9 && fabs(middle - by_hand) <= 1e-5 * by_hand;
  printf("the strip under the wheel sinks by %.4f, by hand %.4f; as new reductions say: %s\n",
         middle, by_hand, good ? "yes" : "no");
  return !good;
}
