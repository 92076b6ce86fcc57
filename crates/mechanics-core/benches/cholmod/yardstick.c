/* Times CHOLMOD on one matrix: analyse, factor, solve, with METIS and with the order given.
 *
 * usage: yardstick matrix.bin repeats
 * matrix.bin, little endian: int64 n, int64 nnz, int64 start[n + 1], int64 row[nnz], double value[nnz] (lower
 * triangle by columns), int64 order[n] (the column at each new position), double b[n].
 * prints one line for each ordering: name flops nnz(L) analyse_ms factor_ms solve_ms residual
 */
#include <cholmod.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double now_ms(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static void must_read(void *to, size_t size, size_t count, FILE *file) {
    if (fread(to, size, count, file) != count) {
        fprintf(stderr, "the matrix file is too short\n");
        exit(2);
    }
}

static double relative_residual(cholmod_sparse *a, cholmod_dense *x, cholmod_dense *b, cholmod_common *c) {
    double one[2] = {1, 0}, minus_one[2] = {-1, 0};
    cholmod_dense *r = cholmod_l_copy_dense(b, c);
    cholmod_l_sdmult(a, 0, minus_one, one, x, r, c);
    double residual = cholmod_l_norm_dense(r, 2, c) / cholmod_l_norm_dense(b, 2, c);
    cholmod_l_free_dense(&r, c);
    return residual;
}

static void measure(const char *name, cholmod_sparse *a, cholmod_dense *b, SuiteSparse_long *order, int repeats,
                    cholmod_common *c) {
    double start = now_ms();
    cholmod_factor *factor = order ? cholmod_l_analyze_p(a, order, NULL, 0, c) : cholmod_l_analyze(a, c);
    double analyse = now_ms() - start, best_factor = 1e300, best_solve = 1e300, residual = 0;
    double flops = c->fl, entries = c->lnz;
    for (int k = 0; k < repeats; k++) {
        start = now_ms();
        if (!cholmod_l_factorize(a, factor, c) || c->status != CHOLMOD_OK) {
            printf("%s failed with status %d\n", name, c->status);
            break;
        }
        double time = now_ms() - start;
        best_factor = time < best_factor ? time : best_factor;
        start = now_ms();
        cholmod_dense *x = cholmod_l_solve(CHOLMOD_A, factor, b, c);
        time = now_ms() - start;
        best_solve = time < best_solve ? time : best_solve;
        residual = relative_residual(a, x, b, c);
        cholmod_l_free_dense(&x, c);
    }
    printf("%s %.6e %.0f %.3f %.3f %.3f %.3e\n", name, flops, entries, analyse, best_factor, best_solve, residual);
    cholmod_l_free_factor(&factor, c);
}

int main(int argc, char **argv) {
    if (argc != 3) {
        fprintf(stderr, "usage: yardstick matrix.bin repeats\n");
        return 2;
    }
    FILE *file = fopen(argv[1], "rb");
    if (!file) {
        perror(argv[1]);
        return 2;
    }
    int64_t sizes[2];
    must_read(sizes, sizeof(int64_t), 2, file);
    size_t n = (size_t)sizes[0], nnz = (size_t)sizes[1];
    cholmod_common c;
    cholmod_l_start(&c);
    cholmod_sparse *a = cholmod_l_allocate_sparse(n, n, nnz, 1, 1, -1, CHOLMOD_REAL, &c);
    must_read(a->p, sizeof(int64_t), n + 1, file);
    must_read(a->i, sizeof(int64_t), nnz, file);
    must_read(a->x, sizeof(double), nnz, file);
    SuiteSparse_long *order = malloc(n * sizeof *order);
    must_read(order, sizeof(int64_t), n, file);
    cholmod_dense *b = cholmod_l_allocate_dense(n, 1, n, CHOLMOD_REAL, &c);
    must_read(b->x, sizeof(double), n, file);
    fclose(file);

    int repeats = atoi(argv[2]);
    c.nmethods = 1;
    c.method[0].ordering = CHOLMOD_GIVEN;
    c.postorder = 1;
    measure("given", a, b, order, repeats, &c);
    c.method[0].ordering = CHOLMOD_METIS;
    measure("metis", a, b, NULL, repeats, &c);

    free(order);
    cholmod_l_free_dense(&b, &c);
    cholmod_l_free_sparse(&a, &c);
    cholmod_l_finish(&c);
    return 0;
}
