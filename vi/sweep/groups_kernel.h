/*
 * groups_kernel.h: kernels of groups_sweep.c for registers of WIDTH doubles, included there once
 * per width. TARGET: the attribute that allows the registers; NAME(x): x for this width.
 *
 * The local solution is local.c's (LO1)-(LO5) without its branches, for W_nn > 0 and S positive
 * definite:
 *
 *   d = 3  stick by Cramer's rule; slip by newton_steps Newton steps from the l of the last visit:
 *          the sweeps correct the rest
 *   d = 2  stick from u_t = z + S r_t = 0; else slip towards that r_t
 */
#define INLINE static TARGET DLSI_INLINE
#define V      NAME(vector)
#define M      NAME(masks)

typedef double V __attribute__((vector_size(8 * WIDTH), aligned(8), may_alias));
typedef long long M __attribute__((vector_size(8 * WIDTH), aligned(8), may_alias));

INLINE V NAME(load)(const double *x) {
  return *(const V *)x;
}

INLINE void NAME(store)(double *x, V v) {
  *(V *)x = v;
}

INLINE V NAME(all)(double x) {
  return x - (V){0};
}

INLINE V NAME(choose)(M yes, V a, V b) {
  return (V)((yes & (M)a) | (~yes & (M)b));
}

INLINE V NAME(abs)(V x) {
  return (V)((M)x & ~(M)(-(V){0}));
}

INLINE V NAME(root)(V x) {
  return ROOT(x);
}

/* x := entry i at each of WIDTH places. */
INLINE V NAME(gather_one)(const double *const *p, int i) {
#if WIDTH == 8
  return (V){p[0][i], p[1][i], p[2][i], p[3][i], p[4][i], p[5][i], p[6][i], p[7][i]};
#elif WIDTH == 4
  return (V){p[0][i], p[1][i], p[2][i], p[3][i]};
#elif WIDTH == 2
  return (V){p[0][i], p[1][i]};
#else
  return (V){p[0][i]};
#endif
}

#if SHUFFLES
#if WIDTH == 8
#define SHUFFLE_LOW(a, b)  __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14)
#define SHUFFLE_HIGH(a, b) __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15)
#elif WIDTH == 4
#define SHUFFLE_LOW(a, b)  __builtin_shufflevector(a, b, 0, 4, 2, 6)
#define SHUFFLE_HIGH(a, b) __builtin_shufflevector(a, b, 1, 5, 3, 7)
#else
#define SHUFFLE_LOW(a, b)  __builtin_shufflevector(a, b, 0, 2)
#define SHUFFLE_HIGH(a, b) __builtin_shufflevector(a, b, 1, 3)
#endif

/* Entries i, i + 1 of places first, first + 2, ... one after another. */
INLINE V NAME(pairs)(const double *const *p, int i, int first) {
#define PAIR(l) (*(const groups_pair *)(p[first + (l)] + i))
#if WIDTH == 2
  return PAIR(0);
#else
  const groups_quad low = __builtin_shufflevector(PAIR(0), PAIR(2), 0, 1, 2, 3);
#if WIDTH == 4
  return low;
#else
  const groups_quad high = __builtin_shufflevector(PAIR(4), PAIR(6), 0, 1, 2, 3);
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#endif
#endif
#undef PAIR
}
#endif

/* x (n) := entries 0 .. n-1 at each of WIDTH places. */
INLINE void NAME(gather)(const int n, const double *const *p, V *x) {
  int i = 0;
#if SHUFFLES
  for (; i + 1 < n; i += 2) {
    const V even = NAME(pairs)(p, i, 0), odd = NAME(pairs)(p, i, 1);
    x[i] = SHUFFLE_LOW(even, odd);
    x[i + 1] = SHUFFLE_HIGH(even, odd);
  }
#endif
  for (; i < n; i++)
    x[i] = NAME(gather_one)(p, i);
}

/* Entries 0 .. n-1 at each of WIDTH places := x (n). */
INLINE void NAME(scatter)(const int n, const V *x, double *const *p) {
  int i = 0;
#if SHUFFLES
  for (; i + 1 < n; i += 2) {
    const V even = SHUFFLE_LOW(x[i], x[i + 1]), odd = SHUFFLE_HIGH(x[i], x[i + 1]);
    for (int l = 0; l < WIDTH; l += 2) {
      *(groups_pair *)(p[l] + i) = (groups_pair){even[l], even[l + 1]};
      *(groups_pair *)(p[l + 1] + i) = (groups_pair){odd[l], odd[l + 1]};
    }
  }
#endif
  for (; i < n; i++)
    for (int l = 0; l < WIDTH; l++)
      p[l][i] = x[i][l];
}

/* s := the solutions for d = 3. own: from the lane on; l there changes. Returns the lanes without a
 * solution. */
INLINE M NAME(solve_3d)(double *own, const V *p, V *s) {
  const V zero = {0};
  V W[9];
  for (int e = 0; e < 9; e++)
    W[e] = NAME(load)(own + 8 * e);
  const V mu = NAME(load)(own + 8 * 12), p0 = p[0], inv_a = 1 / W[0];
  const V c0 = W[1] * inv_a, c1 = W[2] * inv_a;
  const V S0 = W[4] - c0 * W[3], S1 = W[5] - c1 * W[3], S2 = W[7] - c0 * W[6];
  const V S3 = W[8] - c1 * W[6], det = S0 * S3 - S1 * S2, inv_det = 1 / det, trace = S0 + S3;
  const V z0 = p[1] - c0 * p0, z1 = p[2] - c1 * p0;
  const V N0 = S3 * z0 - S2 * z1, N1 = S0 * z1 - S1 * z0;
  const V t0 = -N0 * inv_det, t1 = -N1 * inv_det;
  const V n0 = -(p0 + W[3] * t0 + W[6] * t1) * inv_a, R = mu * n0;
  const M closed = p0 < zero, sticks = closed & (n0 > zero) & (t0 * t0 + t1 * t1 <= R * R);
  const M slips = closed & ~sticks;
  s[0] = (V)(sticks & (M)n0);
  s[1] = (V)(sticks & (M)t0);
  s[2] = (V)(sticks & (M)t1);
  if (!ANY(slips)) return slips;
  const V old = NAME(load)(own + 8 * 13), unit = mu * inv_a;
  const V scale = 0.5 * (NAME(abs)(W[4]) + NAME(abs)(W[8]));
  V l = old;
  for (int step = 0; step < newton_steps; step++) {
    const V inv = 1 / (det + (trace + l) * l), dD = trace + 2 * l, turn = dD * inv;
    const V x = N0 + l * z0, y = N1 + l * z1;
    const V n = NAME(root)(x * x + y * y) * NAME(abs)(inv), n2 = n * n;
    const V m = unit * ((W[3] * x + W[6] * y) * inv - p0), h = n - m;
    const V ndn = (x * z0 + y * z1) * inv * inv - n2 * turn;
    const V dm = unit * (W[3] * z0 + W[6] * z1 - p0 * dD) * inv - m * turn;
    const M up = m > zero;
    const V above = h * NAME(choose)(up, n2 * m, n);
    const V below = NAME(choose)(up, dm * n2 * n - ndn * (m * m), dm * n - ndn);
    const V next = l + above / below, far = 8 * l;
    const V higher = NAME(choose)(next >= l, next, NAME(choose)(far > scale, far, scale));
    const V lower = NAME(choose)((next > zero) & (next <= l), next, l / 8);
    l = NAME(choose)(h > zero, higher, lower); /* n falls and m grows with l */
  }
  const V D = det + (trace + l) * l;
  const V x = N0 + l * z0, y = N1 + l * z1, size = NAME(root)(x * x + y * y);
  const V turn = NAME(choose)(D > zero, NAME(all)(-1), NAME(all)(1)), X = turn * x, Y = turn * y;
  const V f = -p0 / (W[0] * size + mu * (W[3] * X + W[6] * Y));
  const M rough = mu > zero; /* else: along the normal alone */
  const V n = NAME(choose)(rough, f * size, -p0 * inv_a), t = (V)(rough & (M)(mu * f));
  const M good = slips & (n > zero) & (n <= NAME(all)(DBL_MAX));
  NAME(store)(own + 8 * 13, NAME(choose)(good & rough, l, old)); /* mu = 0: l has no end */
  s[0] = NAME(choose)(good, n, s[0]);
  s[1] = NAME(choose)(good, t * X, s[1]);
  s[2] = NAME(choose)(good, t * Y, s[2]);
  return slips & ~good;
}

/* The same for d = 2. */
INLINE M NAME(solve_2d)(const double *own, const V *p, V *s) {
  const V zero = {0}, a = NAME(load)(own), b = NAME(load)(own + 8 * 2), p0 = p[0];
  const V mu = NAME(load)(own + 8 * 6), inv_a = 1 / a, c = NAME(load)(own + 8) * inv_a;
  const V S = NAME(load)(own + 8 * 3) - c * b, z = p[1] - c * p0;
  const V t = -z / S, n = -(p0 + b * t) * inv_a;
  const M closed = p0 < zero, sticks = closed & (n > zero) & (NAME(abs)(t) <= mu * n);
  const V e = NAME(choose)(t > zero, mu, -mu), slip = -p0 / (a + e * b);
  const M good = closed & (sticks | ((slip > zero) & (slip <= NAME(all)(DBL_MAX))));
  s[0] = (V)(good & (M)NAME(choose)(sticks, n, slip));
  s[1] = (V)(good & (M)NAME(choose)(sticks, t, e * slip));
  return closed & ~good;
}

/* ... and for d = 1. */
INLINE M NAME(solve_1d)(const double *own, const V *p, V *s) {
  const M closed = p[0] < (V){0};
  s[0] = (V)(closed & (M)(-p[0] / NAME(load)(own)));
  return (M){0};
}

/* p := q + H^T v, of lanes h .. h + WIDTH - 1 of a group; A, B: the motions of both bodies. */
INLINE void NAME(look_bodies)(const int d, const int n, const double *H, const double *q,
                              const V *A, const V *B, V *p) {
  for (int j = 0; j < d; j++) {
    V sum = NAME(load)(H + 8 * n * j) * A[0], more = NAME(load)(H + 8 * n * (d + j)) * B[0];
    for (int i = 1; i < n; i++) {
      sum += NAME(load)(H + 8 * (i + n * j)) * A[i];
      more += NAME(load)(H + 8 * (i + n * (d + j))) * B[i];
    }
    p[j] = NAME(load)(q + 8 * j) + (sum + more);
  }
}

/* y := W x for a block of each lane. */
INLINE void NAME(multiply)(const int d, const double *W, const V *x, V *y) {
  for (int i = 0; i < d; i++) {
    V sum = NAME(load)(W + 8 * i) * x[0];
    for (int j = 1; j < d; j++)
      sum += NAME(load)(W + 8 * (i + d * j)) * x[j];
    y[i] = sum;
  }
}

/* p := q + the rows of W without the diagonal times r. */
INLINE void NAME(look_blocks)(const int d, const dlsi_groups *G, int g, int h, const double *q,
                              const double *r, V *p) {
  for (int j = 0; j < d; j++)
    p[j] = NAME(load)(q + 8 * j);
  for (int k = G->row[g]; k < G->row[g + 1]; k++) {
    const int *column = G->column + 8 * (size_t)k + h;
    const double *other[WIDTH];
    V x[3], y[3];
    for (int l = 0; l < WIDTH; l++)
      other[l] = r + (size_t)d * (size_t)column[l];
    NAME(gather)(d, other, x);
    NAME(multiply)(d, G->x + 8 * (size_t)(d * d) * (size_t)k + h, x, y);
    for (int i = 0; i < d; i++)
      p[i] += y[i];
  }
}

/* Addresses of the numbers of the eight contacts of a group. */
#define PLACES NAME(places)
typedef struct PLACES {
  double *r[8], *a[8], *b[8]; /* r, the motions of both bodies */
  double none[6];             /* for empty lanes and fixed bodies */
} PLACES;

INLINE void NAME(find)(const int d, const int n, const dlsi_groups *G, int g, double *r, double *v,
                       PLACES *at) {
  const int *member = G->member + 8 * (size_t)g, *body = G->at + 16 * (size_t)g;
  for (int l = 0; l < 8; l++) {
    at->r[l] = member[l] < 0 ? at->none : r + (size_t)d * (size_t)member[l];
    if (!n) continue;
    at->a[l] = body[l] < 0 ? at->none : v + body[l];
    at->b[l] = body[8 + l] < 0 ? at->none : v + body[8 + l];
  }
}

/* (NL1)-(NL4) for lanes h .. h + WIDTH - 1 of a group. Returns 1 if some r has changed. */
INLINE int NAME(visit_lanes)(const int d, const int n, const dlsi_groups *G, int g, int h,
                             const PLACES *at, const double *r) {
  double *own = G->own + 8 * (size_t)(d * d + d + 2) * (size_t)g + h;
  const double *H = G->x + 16 * (size_t)(n * d) * (size_t)g + h, *q = own + 8 * d * d;
  double *const *to = at->r + h, *const *a = at->a + h, *const *b = at->b + h;
  V A[6], B[6], rc[3], p[3], s[3];
  NAME(gather)(d, (const double *const *)to, rc);
  NAME(gather)(n, (const double *const *)a, A);
  NAME(gather)(n, (const double *const *)b, B);
  if (n) {
    NAME(look_bodies)(d, n, H, q, A, B, p);
    NAME(multiply)(d, own, rc, s);
    for (int i = 0; i < d; i++)
      p[i] -= s[i];
  } else
    NAME(look_blocks)(d, G, g, h, q, r, p);
  M left = d == 1   ? NAME(solve_1d)(own, p, s)
           : d == 2 ? NAME(solve_2d)(own, p, s)
                    : NAME(solve_3d)(own, p, s);
  if (ANY(left) || G->odd[g]) {
    for (int l = 0; l < WIDTH; l++) {
      if (!left[l] && !(G->odd[g] >> (h + l) & 1)) continue;
      double one[3] = {p[0][l], d > 1 ? p[1][l] : 0, d > 2 ? p[2][l] : 0};
      dlsi_groups_solve_one(d, own + l, one);
      for (int i = 0; i < d; i++)
        s[i][l] = one[i];
    }
  }
  M moves = s[0] != rc[0];
  for (int i = 1; i < d; i++)
    moves |= s[i] != rc[i];
  if (!ANY(moves)) return 0;
  NAME(scatter)(d, s, to);
  for (int i = 0; i < d; i++)
    s[i] -= rc[i];
  for (int i = 0; i < n; i++) {
    V sum = NAME(load)(H + 8 * i) * s[0], more = NAME(load)(H + 8 * (i + n * d)) * s[0];
    for (int j = 1; j < d; j++) {
      sum += NAME(load)(H + 8 * (i + n * j)) * s[j];
      more += NAME(load)(H + 8 * (i + n * (d + j))) * s[j];
    }
    A[i] += sum;
    B[i] += more;
  }
  NAME(scatter)(n, A, a);
  NAME(scatter)(n, B, b);
  return 1;
}

INLINE int NAME(visit)(const int d, const int n, const dlsi_groups *G, int first, int end,
                       double *r, double *v) {
  PLACES at = {.none = {0}};
  int changed = 0;
  for (int g = first; g < end; g++) {
    NAME(find)(d, n, G, g, r, v, &at);
    for (int h = 0; h < 8; h += WIDTH)
      changed |= NAME(visit_lanes)(d, n, G, g, h, &at, r);
  }
  return changed;
}

/* u := W r + q, from v for bodies, for the contacts of groups first .. end-1. */
INLINE void NAME(see)(const int d, const int n, const dlsi_groups *G, int first, int end, double *r,
                      double *v, double *u) {
  PLACES at = {.none = {0}};
  for (int g = first; g < end; g++) {
    const double *own = G->own + 8 * (size_t)(d * d + d + 2) * (size_t)g, *q = own + 8 * d * d;
    double none[3], *to[8];
    NAME(find)(d, n, G, g, r, v, &at);
    for (int l = 0; l < 8; l++) {
      const int c = G->member[8 * (size_t)g + (size_t)l];
      to[l] = c < 0 ? none : u + (size_t)d * (size_t)c;
    }
    for (int h = 0; h < 8; h += WIDTH) {
      V A[6], B[6], rc[3], p[3], y[3];
      NAME(gather)(n, (const double *const *)at.a + h, A);
      NAME(gather)(n, (const double *const *)at.b + h, B);
      if (n)
        NAME(look_bodies)(d, n, G->x + 16 * (size_t)(n * d) * (size_t)g + h, q + h, A, B, p);
      else {
        NAME(look_blocks)(d, G, g, h, q + h, r, p);
        NAME(gather)(d, (const double *const *)at.r + h, rc);
        NAME(multiply)(d, own + h, rc, y);
        for (int i = 0; i < d; i++)
          p[i] += y[i];
      }
      NAME(scatter)(d, p, to + h);
    }
  }
}

/* Groups first .. end-1: a sweep if u is NULL, which returns 1 if some r has changed; else u. */
static TARGET int NAME(run)(const dlsi_groups *G, int first, int end, double *r, double *v,
                            double *u) {
#define CASE(D, N)                                                                                 \
  if (G->d == D && G->n == N) {                                                                    \
    if (!u) return NAME(visit)(D, N, G, first, end, r, v);                                         \
    NAME(see)(D, N, G, first, end, r, v, u);                                                       \
  }
  CASE(3, 6)
  CASE(3, 0)
  CASE(2, 3)
  CASE(2, 0)
  CASE(1, 6)
  CASE(1, 3)
  CASE(1, 0)
#undef CASE
  return 0;
}

#undef INLINE
#undef V
#undef M
#undef WIDTH
#undef TARGET
#undef NAME
#undef ROOT
#undef ANY
#undef PLACES
#undef SHUFFLE_LOW
#undef SHUFFLE_HIGH
