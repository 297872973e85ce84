// Mutexes asked of OPA: whether a request may be launched, given which others are active.
//
// One policy for all requests, prepared once; which requests must not be active together is its data. Standard input: the
// number of requests; a line for each with the numbers of those that it must not be active with; then a line for each
// decision, the request and the numbers of those that are active. Inputs are parsed beforehand. Prints the mean
// nanoseconds of a decision, and how many were allowed.
package main

import (
	"bufio"
	"context"
	"fmt"
	"log"
	"os"
	"strconv"
	"strings"
	"time"

	"github.com/open-policy-agent/opa/v1/ast"
	"github.com/open-policy-agent/opa/v1/rego"
	"github.com/open-policy-agent/opa/v1/storage/inmem"
)

const policy = `package exover

default allow := false

allow if not excluded

excluded if {
	some other in data.excludes[input.request]
	input.active[other]
}
`

func names(numbers []string) []any {
	found := []any{}
	for _, number := range numbers {
		found = append(found, "r"+number)
	}
	return found
}

func input(fields []string) ast.Value {
	active := map[string]any{}
	for _, number := range fields[1:] {
		active["r"+number] = true
	}
	return ast.MustInterfaceToValue(map[string]any{"request": "r" + fields[0], "active": active})
}

func main() {
	rounds := 1
	if len(os.Args) > 1 {
		rounds, _ = strconv.Atoi(os.Args[1])
	}
	var lines [][]string
	scanner := bufio.NewScanner(os.Stdin)
	scanner.Buffer(nil, 1<<20)
	for scanner.Scan() {
		lines = append(lines, strings.Fields(scanner.Text()))
	}
	size, err := strconv.Atoi(lines[0][0])
	if err != nil {
		log.Fatal(err)
	}
	excludes := map[string]any{}
	for request, line := range lines[1 : size+1] {
		excludes["r"+strconv.Itoa(request)] = names(line)
	}
	store := inmem.NewFromObject(map[string]any{"excludes": excludes})
	ctx := context.Background()
	query, err := rego.New(rego.Query("data.exover.allow"), rego.Module("exover.rego", policy), rego.Store(store)).PrepareForEval(ctx)
	if err != nil {
		log.Fatal(err)
	}
	var inputs []ast.Value
	for _, line := range lines[size+1:] {
		inputs = append(inputs, input(line))
	}
	allowed := 0
	begin := time.Now()
	for range rounds {
		for _, value := range inputs {
			answer, err := query.Eval(ctx, rego.EvalParsedInput(value))
			if err != nil {
				log.Fatal(err)
			}
			if answer.Allowed() {
				allowed++
			}
		}
	}
	spent := float64(time.Since(begin).Nanoseconds()) / float64(rounds*len(inputs))
	fmt.Println(spent, allowed/rounds)
}
