/* test_words.c: numbers in sentences of the program (console.h). */
#include "console/console.h"
#include "run.h"

static const struct {
  double seconds;
  const char *words;
} times[] = {{0, "0 ms"},       {4.12e-6, "0.0041 ms"}, {0.0131, "13 ms"}, {0.0999, "0.1 s"},
             {4.127, "4.1 s"},  {99.6, "100 s"},        {352.2, "352 s"},  {999.4, "999 s"},
             {1370, "23 min"},  {5020, "84 min"},       {7200, "2 h"},     {2.12e5, "59 h"},
             {1.1e7, "3056 h"}, {1e9, "277778 h"}};

TEST_EACH(times_are_read_aloud, 0, sizeof times / sizeof times[0]) {
  ck_assert_str_eq(in_words(times[_i].seconds).text, times[_i].words);
}
