/*
 * delassus.h: the whole library in one include.
 *
 *   status.h     statuses, errors, version
 *   matrix.h     views of matrices
 *   contact.h    the problem and its certificate
 *   limits.h     tolerance, iteration limit, progress
 *   paced.h      progress now and then
 *   info.h       methods and outcome
 *   model.h      K, H_N, H_T of the host
 *   pairs.h      meshes of two bodies -> H_N, H_T, gaps
 *   rigid.h      rigid bodies in space -> H in factors, and back
 *   reduction.h  K, f, H -> W, q and back
 *   global.h     the problem on K itself, without W
 *   solve.h      one call for any method
 *   diagnose.h   facts about a problem
 *   motion.h     load paths, moving obstacles, the theta scheme
 *   trust.h      all solutions of a small problem, the fold, what a residual means
 *   derive.h     derivatives of an answer
 *   nlgs.h       projected Gauss-Seidel on the reactions
 *   primal.h     projected Gauss-Seidel on the displacements
 *   newton.h     nonsmooth Newton
 *   admm.h       splitting with a factorisation
 *   augmented.h  augmented Lagrangian, penalty
 *   lcp.h        LCP(M, q), Lemke, 2D contact as an LCP
 *   facets.h     contact on a cone with facets as an LCP
 *   pivoting.h   LCP: principal pivoting, enumeration
 *   files.h      FCLIB and Matrix Market files (libdelassus-files)
 *   limit.h      the largest load that is carried, with a proof on both sides
 *   layout.h     layouts of these structs, for other languages
 *
 * delassus/fe.h, the finite element module of the benchmark scenes, is a library of its own.
 */
#ifndef DELASSUS_H
#define DELASSUS_H

#include "delassus/admm.h"
#include "delassus/augmented.h"
#include "delassus/contact.h"
#include "delassus/derive.h"
#include "delassus/diagnose.h"
#include "delassus/facets.h"
#include "delassus/files.h"
#include "delassus/global.h"
#include "delassus/info.h"
#include "delassus/layout.h"
#include "delassus/lcp.h"
#include "delassus/limit.h"
#include "delassus/limits.h"
#include "delassus/matrix.h"
#include "delassus/model.h"
#include "delassus/motion.h"
#include "delassus/newton.h"
#include "delassus/nlgs.h"
#include "delassus/paced.h"
#include "delassus/pairs.h"
#include "delassus/pivoting.h"
#include "delassus/primal.h"
#include "delassus/reduction.h"
#include "delassus/rigid.h"
#include "delassus/solve.h"
#include "delassus/status.h"
#include "delassus/trust.h"

#endif
