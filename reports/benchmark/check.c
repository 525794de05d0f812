/* Correct digits of a trajectory of the heavy top benchmark:  check TOP.csv MINE.csv [AT_LEAST]

   cc -O1 check.c -o check -lm.  TOP.csv is a file of the benchmark; MINE.csv has the columns t, p, q, r,
   gamma1, gamma2, gamma3 in any order, and q0, q1, q2, q3 where the attitude is to be judged.  Decimals
   are taken exactly, from 10^9 to 10^-70.  Digits are -log10 of the larger of the error of omega,
   relative to the largest |omega| of TOP.csv, and the error of gamma; of the attitude -log10 of its
   error, of q or -q.  Errors are the largest of a component.  Exit code 0; 1 with fewer digits than
   AT_LEAST or a missing time; 2 for bad input. */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
enum { PLACES = 80, WHOLE = 10, COLUMNS = 11, ROWS = 100000, LINE = 16384 };
static const char *NAMES[] = {"t", "p", "q", "r", "gamma1", "gamma2", "gamma3", "q0", "q1", "q2", "q3"};
typedef signed char Row[COLUMNS][PLACES]; /* of each number its decimal digits, with its sign */
typedef struct { Row *rows; int count, has[COLUMNS]; } Table;

static void fail(const char *what, const char *where) {
  fprintf(stderr, "check TOP.csv MINE.csv [AT_LEAST]: %s %s\n", what, where);
  exit(2);
}
static void number(const char *s, signed char *d) {
  int sign = *s == '-' ? -1 : 1, whole = 0, dot = 0, seen = 0, k;
  const char *first = s + (*s == '-' || *s == '+'), *c;
  for (c = first; isdigit((unsigned char)*c) || (*c == '.' && !dot); c++)
    if (*c == '.') dot = 1; else { seen = 1; if (!dot) whole++; }
  char *end = (char *)c;
  long power = (*c == 'e' || *c == 'E') && (isdigit((unsigned char)c[1]) || (c[1] && c[2])) ? strtol(c + 1, &end, 10) : 0;
  if (!seen || *end) fail("expected a number, not", s);
  power = power > 9999 ? 9999 : power < -9999 ? -9999 : power;
  for (k = WHOLE - whole - (int)power; first < c; first++) {
    if (*first == '.') continue;
    if (k < 0 && *first != '0') fail("expected a number below 1e10, not", s);
    if (k >= 0 && k < PLACES) d[k] = (signed char)(sign * (*first - '0'));
    k++;
  }
}
static double minus(const signed char *a, const signed char *b, int sign) { /* sign*a - b, rounded once it is large */
  double sum = 0;
  for (int k = 0; k < PLACES; k++) sum = 10 * sum + (sign * a[k] - b[k]);
  return sum * pow(10, WHOLE - PLACES);
}
static Table read_table(const char *path) {
  static char line[LINE];
  Table found = {NULL, 0, {0}};
  int of[64], count = 0, k, n;
  FILE *file = fopen(path, "r");
  if (!file) fail("cannot read", path);
  for (n = 0; fgets(line, LINE, file); n++) {
    if (!strchr(line, '\n') && !feof(file)) fail("a line is too long in", path);
    if (n && strspn(line, " \t\r\n") == strlen(line)) continue;
    if (n && found.count % 64 == 0) found.rows = realloc(found.rows, (found.count + 64) * sizeof(Row));
    if (n && (!found.rows || found.count == ROWS)) fail("too many rows in", path);
    if (n) memset(found.rows[found.count], 0, sizeof(Row));
    char *cell = line, *next;
    for (k = 0; cell && k < 64; k++, cell = next) {
      if ((next = strchr(cell, ','))) *next++ = 0;
      while (isspace((unsigned char)*cell)) cell++;
      for (char *e = cell + strlen(cell); e > cell && isspace((unsigned char)e[-1]);) *--e = 0;
      if (n == 0) {
        for (of[k] = COLUMNS - 1; of[k] >= 0 && strcmp(cell, NAMES[of[k]]); of[k]--) {}
        if (of[k] >= 0) found.has[of[k]] = 1;
      } else if (k < count && of[k] >= 0) number(cell, found.rows[found.count][of[k]]);
    }
    if (n == 0) count = k; else if (k != count) fail("rows of different lengths in", path); else found.count++;
  }
  fclose(file);
  for (k = 0; k < 7; k++) if (!found.has[k]) fail("expected a column", NAMES[k]);
  return found;
}
static double error(const Row mine, const Row row, int first, int last, int sign) {
  double worst = 0;
  for (int k = first; k <= last; k++) worst = fmax(worst, fabs(minus(mine[k], row[k], sign)));
  return worst;
}
static double digits(double off) { return off > 0 ? fmin(50, fmax(0, -log10(off))) : 50; }

int main(int argc, char **argv) {
  static const signed char zero[PLACES];
  if (argc < 3) fail("expected", "two files");
  Table top = read_table(argv[1]), mine = read_table(argv[2]);
  double scale = 0, worst = 50;
  for (int n = 0; n < top.count; n++) {
    double w[3];
    for (int k = 0; k < 3; k++) w[k] = minus(top.rows[n][k + 1], zero, 1);
    scale = fmax(scale, sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]));
  }
  puts("t  state  attitude");
  for (int n = 0, m; n < top.count; n++) {
    const signed char (*row)[PLACES] = (const signed char (*)[PLACES])top.rows[n];
    double t = minus(row[0], zero, 1);
    for (m = 0; m < mine.count && fabs(minus(mine.rows[m][0], row[0], 1)) > fabs(t) / 1e9; m++) {}
    if (m == mine.count && t == 0) continue;
    if (m == mine.count) { printf("%g  missing\n", t); worst = 0; continue; }
    const signed char (*own)[PLACES] = (const signed char (*)[PLACES])mine.rows[m];
    double state = digits(fmax(error(own, row, 1, 3, 1) / scale, error(own, row, 4, 6, 1)));
    printf("%g  %.2f", t, state);
    worst = fmin(worst, state);
    if (mine.has[7] && mine.has[8] && mine.has[9] && mine.has[10]) {
      double turn = digits(fmin(error(own, row, 7, 10, 1), error(own, row, 7, 10, -1)));
      printf("  %.2f", turn);
      worst = fmin(worst, turn);
    }
    puts("");
  }
  printf("worst %.2f correct digits\n", worst);
  return argc > 3 && worst < atof(argv[3]);
}
