//! `peers server DOMAIN NAME` and `peers client DOMAIN NAME`: what they are told on standard input, and what they say.
//!
//! The server takes goals of yard_msgs/action/Drive: one above 9 is refused, one below 0 runs until it is cancelled, any
//! other succeeds at once, having gone as far as it should. At the end of its input it says how often it did each.
//!
//! The client does `goal X`, `result K`, `cancel K`, `many N`, where K counts its goals from 0, and answers with one line each.

use std::collections::BTreeSet;
use std::io::BufRead;
use std::thread;
use std::time::Duration;

use futures::channel::mpsc;
use futures::executor::block_on;
use futures::{pin_mut, select, FutureExt, StreamExt};
use ros2_client::action::{
    ActionClient, ActionClientQosPolicies, ActionServerQosPolicies, AsyncActionServer, ExecutingGoalHandle, GoalEndStatus,
};
use ros2_client::qos::{Durability, History};
use ros2_client::{
    ActionTypeName, Context, ContextOptions, Message, Name, Node, NodeName, NodeOptions, QosProfile, ServiceMapping,
};
use ros2_client::unique_identifier_msgs::UUID;
use serde::{Deserialize, Serialize};

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Goal {
    x: f64,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Outcome {
    metres: f64,
    error_code: u16,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Feedback {
    left: f64,
}

impl Message for Goal {}
impl Message for Outcome {}
impl Message for Feedback {}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [role, domain, name] = words.as_slice() else { panic!("peers server|client DOMAIN NAME") };
    let options = ContextOptions::new().domain_id(domain.parse().expect("a domain"));
    let context = Context::with_options(options).expect("a context");
    let node_name = NodeName::new("/", &format!("{role}_{}", std::process::id())).expect("a name");
    let mut node = context.new_node(node_name, NodeOptions::default()).expect("a node");
    let spinner = node.spinner().expect("a spinner");
    thread::spawn(move || block_on(spinner.spin()));
    let (space, last) = name.rsplit_once('/').expect("a name with a /");
    let name = Name::new(if space.is_empty() { "/" } else { space }, last).expect("a name");
    match role.as_str() {
        "server" => block_on(serve(&mut node, &name)),
        "client" => block_on(ask(&mut node, &name)),
        _ => panic!("server or client"),
    }
    node.stop_spinner();
    // That they are gone is said by threads of the context, which end with the process.
    drop((node, context));
    thread::sleep(Duration::from_millis(200));
}

fn volatile() -> QosProfile {
    QosProfile::publisher_default().durability(Durability::Volatile).history(History::KeepAll)
}

fn latched() -> QosProfile {
    QosProfile::publisher_default().durability(Durability::TransientLocal).history(History::KeepLast { depth: 1 })
}

fn drive() -> ActionTypeName {
    ActionTypeName::new("yard_msgs", "Drive")
}

/// Gives the lines of standard input; their end is the end of the process.
fn lines() -> mpsc::UnboundedReceiver<String> {
    let (sender, receiver) = mpsc::unbounded();
    thread::spawn(move || {
        for line in std::io::stdin().lock().lines() {
            sender.unbounded_send(line.expect("a line")).expect("somebody who reads");
        }
    });
    receiver
}

async fn serve(node: &mut Node, name: &Name) {
    let qos = ActionServerQosPolicies {
        goal_service: volatile(),
        result_service: volatile(),
        cancel_service: volatile(),
        feedback_publisher: volatile(),
        status_publisher: latched(),
    };
    let server = node.create_action_server::<Goal, Outcome, Feedback>(ServiceMapping::Cyclone, name, &drive(), qos);
    let server = AsyncActionServer::new(server.expect("a server"));
    let (mut done, mut refused, mut cancelled, mut seen) = (0, 0, 0, BTreeSet::new());
    let mut running: Option<(ExecutingGoalHandle<Goal>, f64)> = None;
    let input = lines();
    pin_mut!(input);
    println!("ready");
    loop {
        select! {
            line = input.next() => if line.is_none() { break },
            handle = server.receive_new_goal().fuse() => {
                let handle = handle.expect("a goal");
                assert!(seen.insert(handle.goal_id()), "a goal came twice");
                let x = server.get_new_goal(handle).expect("its contents").x;
                if x > 9.0 {
                    refused += 1;
                    server.reject_goal(handle).await.expect("to refuse");
                    continue;
                }
                assert!(running.is_none(), "two goals run at once");
                let handle = server.accept_goal(handle).await.expect("to accept");
                let handle = server.start_executing_goal(handle).await.expect("to begin");
                server.publish_feedback(handle, Feedback { left: x }).await.expect("to tell");
                if x < 0.0 {
                    running = Some((handle, x));
                } else {
                    done += 1;
                    end(&server, handle, GoalEndStatus::Succeeded, x).await;
                }
            },
            handle = server.receive_cancel_request().fuse() => {
                let handle = handle.expect("a cancel");
                let goals: Vec<_> = handle.goals().collect();
                server.respond_to_cancel_requests(&handle, goals.iter().copied()).await.expect("to answer");
                if let Some((goal, x)) = running.take_if(|(goal, _)| goals.contains(&goal.goal_id())) {
                    cancelled += 1;
                    end(&server, goal, GoalEndStatus::Canceled, x).await;
                }
            },
        }
    }
    println!("done {done} refused {refused} cancelled {cancelled}");
}

type Server = AsyncActionServer<Goal, Outcome, Feedback>;

async fn end(server: &Server, handle: ExecutingGoalHandle<Goal>, status: GoalEndStatus, x: f64) {
    server.send_result_response(handle, status, Outcome { metres: x, error_code: 0 }).await.expect("to end");
}

async fn ask(node: &mut Node, name: &Name) {
    let qos = ActionClientQosPolicies {
        goal_service: volatile(),
        result_service: volatile(),
        cancel_service: volatile(),
        feedback_subscription: volatile(),
        status_subscription: latched(),
    };
    let client = node.create_action_client::<Goal, Outcome, Feedback>(ServiceMapping::Cyclone, name, &drive(), qos);
    let client = client.expect("a client");
    patiently(|| client.goal_client().wait_for_service(node)).await;
    patiently(|| client.cancel_client().wait_for_service(node)).await;
    patiently(|| client.result_client().wait_for_service(node)).await;
    // Now we know the server. It finds each of our writers by itself, and what it got before is lost: so ask on each.
    let stamp = ros2_client::builtin_interfaces::Time::ZERO;
    patiently(|| async { drop(client.async_request_result(UUID::new_random()).await.expect("an answer")) }).await;
    patiently(|| async { drop(client.async_cancel_goal(UUID::new_random(), stamp).await.expect("an answer")) }).await;
    patiently(|| async { drop(client.async_send_goal(Goal { x: f64::NAN }).await.expect("an answer")) }).await;
    println!("ready");
    let mut goals = Vec::new();
    let mut input = lines();
    while let Some(line) = input.next().await {
        let (verb, argument) = line.split_once(' ').expect("a verb and an argument");
        match verb {
            "goal" => {
                let x = argument.parse().expect("a number");
                let (id, answer) = client.async_send_goal(Goal { x }).await.expect("an answer");
                println!("{}", if answer.accepted { "accepted" } else { "refused" });
                goals.push(id);
            }
            "result" => {
                let id = goals[argument.parse::<usize>().expect("a number")];
                let (status, result) = client.async_request_result(id).await.expect("a result");
                println!("{status:?} {}", result.metres);
            }
            "feedback" => {
                let id = goals[argument.parse::<usize>().expect("a number")];
                let told = client.feedback_stream(id);
                pin_mut!(told);
                println!("{}", told.next().await.expect("feedback").expect("feedback").left);
            }
            "cancel" => {
                let id = goals[argument.parse::<usize>().expect("a number")];
                let stamp = ros2_client::builtin_interfaces::Time::ZERO;
                let answer = client.async_cancel_goal(id, stamp).await.expect("an answer");
                println!("{:?}", answer.return_code);
            }
            "many" => many(&client, argument.parse().expect("a number")).await,
            _ => panic!("{line}"),
        }
    }
}

/// Waits anew each half second: a server that came just before a wait began may be missed by it.
async fn patiently<F: std::future::Future<Output = ()>>(wait: impl Fn() -> F) {
    loop {
        let (sender, late) = futures::channel::oneshot::channel();
        thread::spawn(move || {
            thread::sleep(Duration::from_millis(500));
            sender.send(()).ok();
        });
        let there = wait().fuse();
        pin_mut!(there);
        select! { _ = there => return, _ = late.fuse() => {} }
    }
}

/// Sends goals one after another, and says how many ended how; a result of another goal is a fault.
async fn many(client: &ActionClient<Goal, Outcome, Feedback>, count: u32) {
    let (mut well, mut other, mut refused) = (0, 0, 0);
    for number in 0..count {
        let x = f64::from(number % 9001) / 1000.0;
        let (id, answer) = client.async_send_goal(Goal { x }).await.expect("an answer");
        if !answer.accepted {
            refused += 1;
            continue;
        }
        let (status, result) = client.async_request_result(id).await.expect("a result");
        if format!("{status:?}") == "Succeeded" {
            assert_eq!(result.metres, x, "the result of another goal");
            well += 1;
        } else {
            other += 1;
        }
    }
    println!("well {well} other {other} refused {refused}");
}
