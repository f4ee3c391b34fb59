/*
 * point.cpp: the program of README.md in C++: a point on springs is pushed onto the floor y = 0 and
 * slides to the right.
 *
 * Output:
 *   solved: r_n = 10.9375, r_t = -2.1875, x = 0.9375
 *   solve_model: f: has 1 entry, needs 2
 */
#include <cstdio>

#include "delassus.hpp"

int main() {
  const double K[] = {3, 1, 1, 2};
  const delassus::sparse HN{2, 1, {0, 1}, {1}, {1}}, HT{2, 1, {0, 1}, {0}, {1}}; /* y and x */
  const dls_model model = delassus::model(2, {2, 2, 2, K}, HN, HT);
  const std::vector<double> mu = {0.2};
  try {
    const delassus::answer a = delassus::solve_model(model, {5, -10}, {}, mu);
    std::printf("%s: r_n = %g, r_t = %g, x = %g\n", a.text(), a.r[0], a.r[1], a.x[0]);
    (void)delassus::solve_model(model, {5}, {}, mu);
  } catch (const delassus::error &e) {
    std::printf("%s\n", e.what());
  }
  return 0;
}
