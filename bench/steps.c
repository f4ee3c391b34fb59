/*
 * steps.c: many problems one after the other: a batch of small ones, and the steps of a load path.
 *
 *   steps [--out DIR]
 *       steps.md: CPU of dls_solve_batch beside a loop of dls_solve on boxes with four candidates,
 *       and of a load path of 50 steps, each from the answer of the last, beside the same steps
 *       from nothing
 *
 * Each time is the least of several runs that take turns; seeds are even.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "delassus/solve.h"

/* ---- random numbers -------------------------------------------------------------------------- */

static uint64_t steps_state;

/* Draws from (-1, 1). */
static double steps_draw(void) {
  steps_state = steps_state * 6364136223846793005u + 1442695040888963407u;
  return (double)(steps_state >> 11) * 0x1p-52 - 1;
}

/* ---- boxes ----------------------------------------------------------------------------------- */

enum { corners = 4, box_rows = 3 * corners, boxes = 2000, runs = 7 };

typedef struct box {
  double W[box_rows * box_rows], q[box_rows], mu[corners];
} box;

/* J (3 x 6) := velocity (n, t, s) of the corner (x, y, z) by that of the box and its spin. */
static void box_operator(double x, double y, double z, double J[3][6]) {
  const double arm[3][6] = {{0, 0, 1, y, -x, 0}, {1, 0, 0, 0, z, -y}, {0, 1, 0, -z, 0, x}};
  memcpy(J, arm, sizeof arm);
}

/* Makes a box of random sides on the plane, at rest, sliding or tumbling, after a step of
 * gravity. */
static void box_make(box *b, int kind) {
  const double a[3] = {1 + .5 * steps_draw(), 1 + .5 * steps_draw(), 1 + .5 * steps_draw()};
  double inverse[6], v[6] = {0, 0, -.1, 0, 0, 0};
  for (int i = 0; i < 3; i++) {
    const double s = a[(i + 1) % 3], t = a[(i + 2) % 3];
    inverse[i] = 1;
    inverse[3 + i] = 3 / (s * s + t * t);
    v[i] += kind == 1 && i < 2 ? .3 * steps_draw() : kind == 2 ? .1 * steps_draw() : 0;
    v[3 + i] += kind == 2 ? .1 * steps_draw() : 0;
  }
  double J[corners][3][6];
  for (int c = 0; c < corners; c++) {
    box_operator(c % 2 ? a[0] : -a[0], c / 2 ? a[1] : -a[1], -a[2], J[c]);
    b->mu[c] = .5;
  }
  for (int i = 0; i < box_rows; i++) {
    b->q[i] = 0;
    for (int k = 0; k < 6; k++)
      b->q[i] += J[i / 3][i % 3][k] * v[k];
    for (int j = 0; j < box_rows; j++) {
      double sum = 0;
      for (int k = 0; k < 6; k++)
        sum += J[i / 3][i % 3][k] * inverse[k] * J[j / 3][j % 3][k];
      b->W[i + box_rows * j] = sum;
    }
  }
}

static dls_contact box_contact(const box *b) {
  return (dls_contact){.d = 3,
                       .nc = corners,
                       .W = {box_rows, box_rows, box_rows, b->W},
                       .q = b->q,
                       .mu = b->mu};
}
int main(int argc, char **argv) {
  static box b[boxes];
  static double r[boxes][box_rows];
  dls_solver_settings s;
  dls_solver_settings_init(&s);
  
  steps_state=3;
  for (int kind = argc>1?1:0; kind < (argc>1?2:3); kind++) {
    for (int k = 0; k < boxes; k++) box_make(&b[k], kind);
    double best[4]; for(int i=0;i<4;i++) best[i]=INFINITY; int ok=0,it=0,fac=0;
    dls_solver *solver; if(dls_solver_create(&solver,3,4,&s,NULL)) return 1;
    for (int run = 0; run < (argc>1?200:runs); run++) {
      double t=bench_seconds(); ok=it=fac=0;
      if(argc<2) for (int k = 0; k < boxes; k++) { dls_contact p=box_contact(&b[k]); dls_info info; ok += dls_solve(&p,&s,r[k],NULL,&info,NULL)==0; it+=info.iterations; fac+=info.factorisations;}
      best[0]=fmin(best[0],bench_seconds()-t);
      t=bench_seconds();
      if(argc<2) for (int k = 0; k < boxes; k++) { dls_contact p=box_contact(&b[k]); if(dls_solver_solve(solver,&p,r[k],NULL,NULL,NULL)<0) return 1;}
      best[1]=fmin(best[1],bench_seconds()-t);
      t=bench_seconds();
      if(argc<2) for (int k = 0; k < boxes; k++) { dls_contact p=box_contact(&b[k]); if(dls_solve(&p,&s,r[k],NULL,NULL,NULL)<0) return 1;}
      best[2]=fmin(best[2],bench_seconds()-t);
      static dls_contact all[boxes]; static double *rr[boxes]; static dls_info inf[boxes];
      for (int k = 0; k < boxes; k++) { all[k]=box_contact(&b[k]); rr[k]=r[k]; }
      t=bench_seconds();
      if(dls_solve_batch(boxes,all,&s,rr,NULL,NULL,NULL)<0) return 1;
      best[3]=fmin(best[3],bench_seconds()-t);
      if(run==0){ if(dls_solve_batch(boxes,all,&s,rr,NULL,inf,NULL)<0) return 1; int n=0,sw=0; for(int k=0;k<boxes;k++){ n+= inf[k].certificate.worst>=-1 && inf[k].factorisations==0 && inf[k].iterations%2==0 && inf[k].iterations <=40 && inf[k].status==0; sw+=inf[k].iterations; } printf("lanes %d sweeps %.1f\n",n,(double)sw/boxes);}

    }
    printf("kind %d ok %d it %.1f fac %.1f: solve+info %.2f us, solver %.2f us, solve %.2f batch %.2f\n",kind,ok,(double)it/boxes,(double)fac/boxes,best[0]/boxes*1e6,best[1]/boxes*1e6,best[2]/boxes*1e6,best[3]/boxes*1e6);
    dls_solver_destroy(solver);
  }
  (void)argc; (void)argv;
}
