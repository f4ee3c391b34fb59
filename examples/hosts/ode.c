/*
 * ode.c: ODE as the host of rigid bodies. ODE has the bodies and finds the contacts; delassus
 * solves the step in place of dWorldStep. A box slides down a slope of 1:2 with friction .3, and
 * ten boxes stand upon each other.
 *
 * Output:
 *   slope: 100 steps solved, speed as by hand to 1e-9: yes
 *   stack: 100 steps solved, the floor carries the weight to 1e-7: yes, the top stays to 1e-6: yes
 */
#include <delassus.h>
#include <math.h>
#include <ode/ode.h>
#include <stdio.h>

enum { most_bodies = 16, most = 256, steps = 100 };
static const double h = 0.01, g = 9.81, dv = 9.81 * 0.01; /* dv: gravity in a step */
static dWorldID world;
static dSpaceID space;
static dBodyID body_of[most_bodies];
static int bodies;
static double friction;
static dls_rigid B[most_bodies]; /* dBodyGetData of body_of[b] is &B[b] */
static double H[36 * most], q[3 * most], mu[most], r[3 * most];
static int pair[2 * most], nc;
static dls_error error;
static dMass m;

_Static_assert(sizeof(dReal) == sizeof(double), "ODE in double precision");

/* -> delassus */
static int number(dBodyID b) { return b ? (int)((dls_rigid *)dBodyGetData(b) - B) : -1; }
static void near(void *status, dGeomID a, dGeomID b) {
  dContactGeom c[8];
  for (int k = 0, count = dCollide(a, b, 8, c, sizeof *c); k < count; mu[nc++] = friction, k++)
    *(int *)status |= dls_rigid_contact(bodies, B, number(dGeomGetBody(a)), number(dGeomGetBody(b)),
        c[k].pos, c[k].normal, 0, nc, pair, H, q, NULL, &error);
}
static int step(void) {
  int status = nc = 0;
  for (int b = 0; b < bodies; b++) { /* ODE's matrices have rows of four */
    const double *R = dBodyGetRotation(body_of[b]), *v = dBodyGetLinearVel(body_of[b]);
    const double *x = dBodyGetPosition(body_of[b]), *w = dBodyGetAngularVel(body_of[b]);
    dBodyGetMass(body_of[b], &m);
    B[b] = (dls_rigid){m.mass, .x = {x[0], x[1], x[2]}, {v[0], v[1], v[2]-dv}, {w[0], w[1], w[2]}};
    for (int k = 0; k < 9; k++) B[b].inertia[k] = m.I[k + k / 3], B[b].R[k] = R[k + k / 3];
  }
  dSpaceCollide(space, &status, near);
  dls_contact problem = {.d = 3, .nc = nc, .q = q, .mu = mu, .bodies = {6, bodies, pair, H, NULL}};
  if (!status) status = dls_solve(&problem, NULL, r, NULL, NULL, &error);
  if (status >= 0) status |= dls_rigid_apply(bodies, B, nc, pair, H, r, &error);
  for (int b = 0; b < bodies; b++) dBodySetLinearVel(body_of[b], B[b].v[0], B[b].v[1], B[b].v[2]),
      dBodySetAngularVel(body_of[b], B[b].w[0], B[b].w[1], B[b].w[2]);
  dWorldStep(world, h); /* without gravity and joints: positions alone */
  return status;
}
/* <- delassus */

static void ode_begin(double slope, double with_friction) {
  world = dWorldCreate();
  space = dSimpleSpaceCreate(0);
  friction = with_friction;
  bodies = 0;
  dCreatePlane(space, sin(slope), 0, cos(slope), 0);
}

static void ode_box(double x, double z, double turned) {
  dMatrix3 R;
  const dBodyID b = dBodyCreate(world);
  const dGeomID e = dCreateBox(space, 0.4, 0.3, 0.2);
  dMassSetBox(&m, 1000, 0.4, 0.3, 0.2); /* 24 kg */
  dBodySetMass(b, &m);
  dBodySetPosition(b, x, 0, z);
  dRFromAxisAndAngle(R, 0, 1, 0, turned);
  dBodySetRotation(b, R);
  dGeomSetBody(e, b);
  dBodySetData(b, &B[bodies]);
  body_of[bodies++] = b;
}

/* Returns 1 if each step was solved. */
static int ode_run(void) {
  for (int k = 0; k < steps; k++) {
    const int status = step();
    if (status < 0) puts(error.message);
    if (status != DLS_OK && status != DLS_TO_ROUNDING) return 0;
  }
  return 1;
}

static const char *yes(int is) {
  return is ? "yes" : "no";
}

int main(void) {
  const double a = atan(0.5), up = 0.1 - 1e-6;
  dInitODE();
  ode_begin(a, 0.3);
  ode_box(up * sin(a), up * cos(a), a);
  if (!ode_run()) return 1;
  const double speed = steps * h * g * (sin(a) - 0.3 * cos(a));
  const int as_by_hand = fabs(hypot(B[0].v[0], B[0].v[2]) - speed) <= 1e-9 * speed;
  printf("slope: %d steps solved, speed as by hand to 1e-9: %s\n", steps, yes(as_by_hand));
  dWorldDestroy(world);
  ode_begin(0, 0.5);
  for (int k = 0; k < 10; k++)
    ode_box(0.003 * (k % 3), 0.1 + 0.2 * k - 1e-6 * (k + 1), 0);
  const double top = dBodyGetPosition(body_of[9])[2];
  if (!ode_run()) return 1;
  double floor = 0, weight = 240 * g * h;
  for (int c = 0; c < nc; c++)
    if (pair[2 * c] < 0 || pair[2 * c + 1] < 0) floor += r[3 * c];
  const int carries = fabs(floor - weight) <= 1e-7 * weight;
  const int stays = fabs(dBodyGetPosition(body_of[9])[2] - top) <= 1e-6;
  printf("stack: %d steps solved, the floor carries the weight to 1e-7: %s, the top stays to 1e-6: "
         "%s\n", steps, yes(carries), yes(stays));
  dWorldDestroy(world);
  dCloseODE();
  return !(as_by_hand && carries && stays);
}
