/* fclib_file.c: implements fclib_file.h. */
#include "fclib_file.h"

#include <check.h>
#include <stdio.h>

const char *const fclib_files[fclib_count] = {"Confeti-ex13-4contact-Fc3D-SBM",
                                              "CubeH8",
                                              "FC2D_SliderCrankLagrangian00000",
                                              "FC3D_Example1",
                                              "GFC3D_Example0",
                                              "GFC3D_OneContact",
                                              "gfc2d_granularflowonwall_00069_00350"};

dls_fclib *read_fclib_file(const char *name) {
  char path[200];
  (void)snprintf(path, sizeof path, TEST_DATA "/fclib/%s.hdf5", name);
  dls_fclib *file = NULL;
  dls_error error = {0};
  const dls_status status = dls_fclib_read(&file, path, &error);
  if (status == DLS_E_UNSUPPORTED) return NULL;
  ck_assert_msg(status == DLS_OK, "%s", error.message);
  return file;
}
