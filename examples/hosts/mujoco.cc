/*
 * mujoco.cc: MuJoCo as the host. A box slides down a slope of 1 : 2 with friction .3 for a second.
 * MuJoCo finds the contacts, their Jacobian and the mass matrix M; delassus takes the place of its
 * contact solver: M v = M (v + h a) + H r. By hand the box has v = g t (sin - .3 cos) at the end.
 * MuJoCo's own contact is soft: its box creeps on.
 *
 * Output:
 *   delassus: 500 of 500 steps solved, v by hand to 1e-9: yes
 *   MuJoCo: v by hand to 1e-9: no
 */
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <delassus.hpp>
#include <mujoco/mujoco.h>

/* Takes a step as mj_step does; returns 1 if its contacts are solved. */
static int step(const mjModel *m, mjData *d) {
  const int n = m->nv, nc = d->ncon;
  const double h = m->opt.timestep;
  /* -> delassus */
  std::vector<double> M(n * n), v(n), f(n), g(3 * nc), mu(nc);
  delassus::sparse HN{n}, HT{n};
  mj_fullM(m, M.data(), d->qM);
  mju_addScl(v.data(), d->qvel, d->qacc_smooth, h, n);
  mju_mulMatVec(f.data(), M.data(), v.data(), n, n);
  for (int c = 0; c < nc; c++) {
    const double *J = d->efc_J + n * d->contact[c].efc_address;
    HN.append(J), HT.append(J + n), HT.append(J + 2 * n);
    g[3 * c] = std::max(d->contact[c].dist, 0.0) / h, mu[c] = d->contact[c].friction[0];
  }
  const auto a = delassus::solve_model(delassus::model(3, {n, n, n, M.data()}, HN, HT), f, g, mu);
  mju_copy(d->qvel, a.x.data(), n);
  /* <- delassus */
  mj_integratePos(m, d->qpos, d->qvel, h);
  return a.solved();
}

int main(int argc, char **argv) {
  char why[500];
  mjModel *m = argc > 1 ? mj_loadXML(argv[1], nullptr, why, sizeof why) : nullptr;
  if (!m) return std::printf("mujoco FILE.xml: %s\n", argc > 1 ? why : "no file"), 1;
  const int steps = 500;
  const double slope = std::atan(0.5), t = steps * m->opt.timestep;
  const double by_hand = -m->opt.gravity[2] * t * (std::sin(slope) - 0.3 * std::cos(slope));
  for (int own = 0; own < 2; own++) {
    mjData *d = mj_makeData(m);
    int solved = 0;
    for (int k = 0; k < steps; k++) {
      if (own) {
        mj_step(m, d);
        continue;
      }
      mj_step1(m, d);
      mj_fwdActuation(m, d);
      mj_fwdAcceleration(m, d);
      solved += step(m, d);
    }
    const double v = std::hypot(d->qvel[0], d->qvel[2]);
    std::fprintf(stderr, "v = %.12f, by hand %.12f\n", v, by_hand);
    if (own)
      std::printf("MuJoCo:");
    else
      std::printf("delassus: %d of %d steps solved,", solved, steps);
    const bool exact = std::fabs(v - by_hand) <= 1e-9 * by_hand;
    std::printf(" v by hand to 1e-9: %s\n", exact ? "yes" : "no");
    mj_deleteData(d);
  }
  mj_deleteModel(m);
  return 0;
}
