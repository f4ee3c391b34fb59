/*
 * mujoco.cc: MuJoCo as the host. A box slides down a slope of 1 : 2 with friction .3 for a second,
 * and a capsule lies on a slope of 1 : 3 with friction 1. MuJoCo finds the contacts, their Jacobian
 * and the mass matrix M; delassus takes the place of its contact solver: M v = M (v + h a) + H r. By
 * hand the box has v = g t (sin - .3 cos) at the end, and the capsule rests. MuJoCo's own contact is
 * soft: its box and its capsule creep on (docs/stick.md).
 *
 * Output:
 *   delassus: 500 of 500 steps solved, box by hand to 1e-9: yes, capsule at 0 um/s
 *   MuJoCo: 500 of 500 steps solved, box by hand to 1e-9: no, capsule at 157 um/s
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

/* Returns the speed after 500 steps of the scene, by MuJoCo's own step or by the one above; adds the
 * steps that are solved to *solved. */
static double run(const mjModel *m, bool own, int *solved) {
  mjData *d = mj_makeData(m);
  for (int k = 0; k < 500; k++) {
    if (own) {
      mj_step(m, d);
      ++*solved;
      continue;
    }
    mj_step1(m, d);
    mj_fwdActuation(m, d);
    mj_fwdAcceleration(m, d);
    *solved += step(m, d);
  }
  const double v = std::hypot(d->qvel[0], d->qvel[2]);
  mj_deleteData(d);
  return v;
}

int main(int argc, char **argv) {
  char why[500] = "mujoco BOX.xml CAPSULE.xml";
  mjModel *box = argc > 2 ? mj_loadXML(argv[1], nullptr, why, sizeof why) : nullptr;
  mjModel *capsule = box ? mj_loadXML(argv[2], nullptr, why, sizeof why) : nullptr;
  if (!capsule) return std::puts(why), 1;
  const double slope = std::atan(0.5), t = 500 * box->opt.timestep;
  const double by_hand = -box->opt.gravity[2] * t * (std::sin(slope) - 0.3 * std::cos(slope));
  for (bool own : {false, true}) {
    int solved = 0, rests = 0;
    const double v = run(box, own, &solved), creep = run(capsule, own, &rests);
    std::fprintf(stderr, "v = %.12f, by hand %.12f; capsule %.3g m/s\n", v, by_hand, creep);
    std::printf("%s: %d of 500 steps solved, box by hand to 1e-9: %s, capsule at %.0f um/s\n",
                own ? "MuJoCo" : "delassus", std::min(solved, rests),
                std::fabs(v - by_hand) <= 1e-9 * by_hand ? "yes" : "no", 1e6 * creep);
  }
  mj_deleteModel(capsule);
  mj_deleteModel(box);
  return 0;
}
