/* door.cpp: prints the lines that test_door.c compares, by delassus.hpp. */
#include <cinttypes>
#include <cstdio>
#include <cstring>

#include "delassus.hpp"

static void put(const char *name, const delassus::answer &a, const dls_certificate &c) {
  const double all[] = {a.r[0], a.r[1], a.u[0], a.u[1], a.x[0], a.x[1], c.residual, c.equilibrium};
  std::printf("%s %d", name, static_cast<int>(a.status));
  for (double value : all) {
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    std::printf(" %016" PRIX64, bits);
  }
  std::printf("\n");
}

int main() {
  const double K[] = {3, 1, 1, 2}, spring[] = {5, -5, -5, 5};
  const delassus::sparse first{2, 1, {0, 1}, {0}, {1}}, second{2, 1, {0, 1}, {1}, {1}};
  const delassus::sparse none{2, 1, {0, 0}, {}, {}};
  const dls_model held = delassus::model(2, {2, 2, 2, K}, second, first);
  const dls_model loose = delassus::model(2, {2, 2, 2, spring}, first, none);
  const std::vector<double> mu = {0.2};
  const delassus::answer one = delassus::solve_model(held, {5, -10}, {}, mu);
  put("held", one, one.info.certificate);
  delassus::reduction_settings settings;
  settings.on = DLS_ON_K;
  delassus::reduction reduction(held, settings);
  reduction.load({5, -10});
  delassus::answer a = reduction.solve(mu);
  const dls_certificate c = reduction.certify(mu, a.r, a.x, &a.u);
  put("on-K", a, c);
  const delassus::answer pressed = delassus::solve_model(loose, {0, -10}, {1, 0}, {0});
  put("pressed", pressed, pressed.info.certificate);
  settings.on = DLS_ON_W;
  try {
    delassus::reduction on_W(loose, settings);
  } catch (const delassus::error &e) {
    std::printf("on-W %d\n", static_cast<int>(e.status()));
  }
  const delassus::answer flies = delassus::solve_model(loose, {0, 10}, {1, 0}, {0});
  put("flies", flies, flies.info.certificate);
  return 0;
}
