/*
 * host_steps.c: a hundred spheres that fall on the floor, one second in steps of time. Contacts
 * appear and vanish; the host tells the solver which of them it knows (dls_solver_map), so
 * that each step starts from what the last one left.
 *
 * Output:
 *   200 of 200 steps solved
 *   nine contacts in ten known from the step before: yes
 *   no sphere more than 1 mm in the floor: yes
 */
#include <delassus.h>
#include <math.h>
#include <stdio.h>

enum { spheres = 100, most = 8 * spheres, d = 3, n = 6, steps = 200 };

static const double h = 5e-3, g = 9.81, radius = 0.05, mass = 1, margin = 0.02;

/* The contacts of a step: sphere a, and b below it, -1: the floor. */
typedef struct contacts {
  int count, body[2 * most];
  double frame[most][3][3]; /* n, t, s */
} contacts;

static double x[spheres][3], v[spheres][6]; /* middles; velocities and spins */
static double H[2 * n * d * most], q[d * most], mu[most];
static contacts now, last;
static int from[most];

static double scalar_product(const double *a, const double *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void vector_product(const double *a, const double *b, double *c) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

/* Returns the contact of the same pair in the last step, -1: there was none. */
static int find_pair(int a, int b) {
  for (int c = 0; c < last.count; c++)
    if (last.body[2 * c] == a && last.body[2 * c + 1] == b) return c;
  return -1;
}

/* t is carried along with a contact that stays: r is known in its frame. */
static void set_frame(int c, const double *normal) {
  static const double axes[2][3] = {{1, 0, 0}, {0, 1, 0}};
  double(*f)[3] = now.frame[c];
  const double *t = from[c] >= 0 ? last.frame[from[c]][1] : axes[fabs(normal[0]) > 0.7];
  const double along = scalar_product(normal, t);
  for (int i = 0; i < d; i++)
    f[0][i] = normal[i];
  for (int i = 0; i < d; i++)
    f[1][i] = t[i] - along * normal[i];
  const double length = sqrt(scalar_product(f[1], f[1]));
  for (int i = 0; i < d; i++)
    f[1][i] /= length;
  vector_product(f[0], f[1], f[2]);
}

static void close_in(int a, int b, const double *normal, double gap) {
  const int c = now.count++;
  now.body[2 * c] = a;
  now.body[2 * c + 1] = b;
  from[c] = find_pair(a, b);
  set_frame(c, normal);
  mu[c] = 0.5;
  for (int j = 0; j < d; j++) {
    const double *e = now.frame[c][j];
    double arm[3] = {-radius * normal[0], -radius * normal[1], -radius * normal[2]}, turn[3];
    vector_product(arm, e, turn); /* b, on the other side, turns the same way */
    q[d * c + j] = j ? 0 : gap / h;
    for (int side = 0; side < 2; side++) {
      const int k = now.body[2 * c + side];
      double *to = H + n * d * (2 * c + side) + n * j;
      if (k < 0) continue;
      for (int i = 0; i < 3; i++) {
        to[i] = (side ? -e[i] : e[i]) / sqrt(mass);
        to[3 + i] = turn[i] / sqrt(0.4 * mass * radius * radius);
      }
      q[d * c + j] += (side ? -1 : 1) * (scalar_product(v[k], e) - g * h * e[2]) +
                      scalar_product(v[k] + 3, turn);
    }
  }
}

static void look_for_contacts(void) {
  static const double up[3] = {0, 0, 1};
  last = now;
  now.count = 0;
  for (int a = 0; a < spheres; a++) {
    if (x[a][2] - radius < margin) close_in(a, -1, up, x[a][2] - radius);
    for (int b = 0; b < a; b++) {
      double normal[3] = {x[a][0] - x[b][0], x[a][1] - x[b][1], x[a][2] - x[b][2]};
      const double length = sqrt(scalar_product(normal, normal));
      for (int i = 0; i < 3; i++)
        normal[i] /= length;
      if (length - 2 * radius < margin) close_in(a, b, normal, length - 2 * radius);
    }
  }
}

static void move_spheres(const double *r) {
  for (int a = 0; a < spheres; a++)
    v[a][2] -= g * h;
  for (int k = 0; k < 2 * now.count; k++) {
    const int a = now.body[k];
    for (int i = 0; a >= 0 && i < n; i++)
      for (int j = 0; j < d; j++)
        v[a][i] += H[n * d * k + n * j + i] * r[d * (k / 2) + j] /
                   (i < 3 ? sqrt(mass) : sqrt(0.4 * mass * radius * radius));
  }
  for (int a = 0; a < spheres; a++)
    for (int i = 0; i < 3; i++)
      x[a][i] += h * v[a][i];
}

int main(void) {
  static double r[d * most];
  dls_solver *solver;
  dls_solver_settings settings;
  dls_error error;
  for (int a = 0; a < spheres; a++) { /* layers of 5 x 5, each a little aside */
    x[a][0] = 0.11 * (a % 5) + 0.03 * (a / 25 % 2) + 0.001 * (a % 7);
    x[a][1] = 0.11 * (a / 5 % 5) + 0.02 * (a / 25 % 2) + 0.001 * (a % 3);
    x[a][2] = 0.06 + 0.12 * (a / 25);
  }
  dls_solver_settings_init(&settings);
  settings.limits.tol = 1e-4;
  settings.limits.warm_start = 1;
  settings.limits.blocks = 20 * most;
  dls_status status = dls_solver_create(&solver, d, most, &settings, &error);
  int solved = 0, known = 0, all = 0;
  double deepest = 0;
  while (dls_solved(status) && solved < steps) {
    look_for_contacts();
    dls_contact problem = {.d = d, .nc = now.count, .q = q, .mu = mu};
    problem.bodies = (dls_bodies){n, spheres, now.body, H, NULL};
    status = dls_solver_map(solver, now.count, from, r, &error);
    if (!status) status = dls_solver_solve(solver, &problem, r, NULL, NULL, &error);
    if (!dls_solved(status)) break;
    solved++;
    move_spheres(r);
    all += now.count;
    for (int c = 0; c < now.count; c++)
      known += from[c] >= 0;
    for (int a = 0; a < spheres; a++)
      deepest = fmax(deepest, radius - x[a][2]);
  }
  if (status < 0) return fprintf(stderr, "%s\n", error.message);
  printf("%d of %d steps solved\n", solved, steps);
  printf("nine contacts in ten known from the step before: %s\n",
         10 * known >= 9 * all ? "yes" : "no");
  printf("no sphere more than 1 mm in the floor: %s\n", deepest <= 1e-3 ? "yes" : "no");
  dls_solver_destroy(solver);
  return 0;
}
