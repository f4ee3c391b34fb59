/*
 * delassus.h: the whole library in one include.
 *
 *   status.h     statuses and errors             lcp.h    LCP(M, q), Lemke, 2D contact as an LCP
 *   matrix.h     views of matrices               nlgs.h   projected Gauss-Seidel
 *   contact.h    the problem, its certificate    solve.h  one call for any method
 *   reduction.h  K, f, H -> W, q and back        files.h  FCLIB and Matrix Market files
 *   info.h       progress and outcome
 *
 * delassus/fe.h, the finite element module of the benchmark scenes, is a library of its own.
 */
#ifndef DELASSUS_H
#define DELASSUS_H

#include "delassus/contact.h"
#include "delassus/files.h"
#include "delassus/info.h"
#include "delassus/lcp.h"
#include "delassus/matrix.h"
#include "delassus/nlgs.h"
#include "delassus/pivoting.h"
#include "delassus/reduction.h"
#include "delassus/solve.h"
#include "delassus/status.h"

#endif
