/* unsymmetric.h: a contact problem whose K only MUMPS factorises. */

/* Returns 0 if delassus solves it: |K x - f - H r| <= 1e-10 |f|. Else prints what is wrong. */
int unsymmetric_wrong(void);
