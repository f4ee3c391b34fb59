/*
 * papers_material.h: the flow rule that the forming scenes of bench/papers integrate.
 */
#ifndef BENCH_PAPERS_MATERIAL_H
#define BENCH_PAPERS_MATERIAL_H

#include "fe/solid.h"

/* 0: the library's radial return (12); 1: the exponential return of (6). Read by dlsi_solid_update
 * of this program, which stands in the place of the library's. */
extern int papers_exponential;

#endif
