//! Mutexes asked of Cedar: whether a request may be launched, given which others are active.
//!
//! Every request is an action with a policy set of its own (policies sliced by action): a permit, and for each of those
//! that it must not be active with a forbid. Standard input: the number of requests; a line for each with the numbers of
//! those; then a line for each decision, the request and the numbers of those that are active. Requests, contexts and
//! policy sets are made beforehand. Prints the mean nanoseconds of a decision, and how many were allowed.

use cedar_policy::{
    Authorizer, Context, Decision, Entities, EntityUid, PolicySet, Request, RestrictedExpression,
};
use std::error::Error;
use std::io::Read;
use std::time::Instant;

type Fallible<T> = Result<T, Box<dyn Error>>;

fn policies(request: usize, excluded: &[usize]) -> Fallible<PolicySet> {
    let mut text = format!("permit(principal, action == Action::\"r{request}\", resource);\n");
    for other in excluded {
        text += &format!(
            "forbid(principal, action == Action::\"r{request}\", resource) when {{ context.active.contains(\"r{other}\") }};\n"
        );
    }
    Ok(text.parse()?)
}

fn question(request: usize, active: &[usize]) -> Fallible<Request> {
    let planner: EntityUid = "Client::\"planner\"".parse()?;
    let robot: EntityUid = "Robot::\"robot\"".parse()?;
    let action: EntityUid = format!("Action::\"r{request}\"").parse()?;
    let names = active
        .iter()
        .map(|number| RestrictedExpression::new_string(format!("r{number}")));
    let pairs = [("active".to_string(), RestrictedExpression::new_set(names))];
    Ok(Request::new(planner, action, robot, Context::from_pairs(pairs)?, None)?)
}

fn main() -> Fallible<()> {
    let rounds: usize = std::env::args().nth(1).map_or(Ok(1), |text| text.parse())?;
    let mut text = String::new();
    std::io::stdin().read_to_string(&mut text)?;
    let mut lines = Vec::new();
    for line in text.lines() {
        let numbers: Result<Vec<usize>, _> = line.split_whitespace().map(str::parse).collect();
        lines.push(numbers?);
    }
    let (rows, decisions) = lines[1..].split_at(lines[0][0]);
    let mut sets = Vec::new();
    for (request, excluded) in rows.iter().enumerate() {
        sets.push(policies(request, excluded)?);
    }
    let mut questions = Vec::new();
    for line in decisions {
        questions.push((line[0], question(line[0], &line[1..])?));
    }
    let (authorizer, entities) = (Authorizer::new(), Entities::empty());
    let mut allowed = 0;
    let begin = Instant::now();
    for _ in 0..rounds {
        for (request, question) in &questions {
            let response = authorizer.is_authorized(question, &sets[*request], &entities);
            allowed += usize::from(response.decision() == Decision::Allow);
        }
    }
    let spent = begin.elapsed().as_nanos() as f64 / (rounds * questions.len()) as f64;
    println!("{spent} {}", allowed / rounds);
    Ok(())
}
