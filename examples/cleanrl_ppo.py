"""PPO in one file, in the style of CleanRL's `ppo.py`, over a batch of crawlers stepped in one compiled call.

Schulman et al., "Proximal Policy Optimization Algorithms" (2017), with the generalised advantages of "High-Dimensional
Continuous Control Using Generalized Advantage Estimation" (2015). Copy the file and change what you like.
"""

import argparse
from dataclasses import dataclass, fields

import gymnasium as gym
import numpy as np
import torch
from torch import nn
from torch.distributions import Categorical


@dataclass
class Args:
    """What can be set from the shell: ``--num-envs 256``."""

    seed: int = 0
    memory_weight: float = 0.2  # share of memory in the reward
    dither: float = 0.1  # probability that a command is flipped
    total_timesteps: int = 200_000
    num_envs: int = 256
    num_steps: int = 32  # of each environment in a rollout
    learning_rate: float = 1e-3
    gamma: float = 0.98
    gae_lambda: float = 0.95
    num_minibatches: int = 4
    update_epochs: int = 4
    clip_coef: float = 0.2
    ent_coef: float = 0.003
    vf_coef: float = 0.5
    max_grad_norm: float = 0.5


class Agent(nn.Module):
    """An actor and a critic of two layers of 64."""

    def __init__(self) -> None:
        super().__init__()
        self.critic, self.actor = (
            nn.Sequential(nn.Linear(5, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, size))
            for size in (1, 2)
        )

    def value(self, observations: torch.Tensor) -> torch.Tensor:
        """Expected discounted return."""
        return self.critic(observations).squeeze(-1)

    def policy(self, observations: torch.Tensor) -> Categorical:
        """Distribution of the valve command."""
        return Categorical(logits=self.actor(observations))


def make(args: Args) -> gym.vector.VectorEnv:
    """The batch, whose episodes restart in the step that ends them, so that no step is lost."""
    return gym.make_vec(
        "StickSlipCrawler-v0",
        args.num_envs,
        memory_weight=args.memory_weight,
        dither=args.dither,
        autoreset_mode=gym.vector.AutoresetMode.SAME_STEP,
    )


def evaluate(agent: Agent, args: Args) -> float:
    """Mean reward a step of one greedy episode in each environment."""
    envs = make(args)
    observations, _ = envs.reset(seed=1_000_000)
    total = 0.0
    for _ in range(1000):
        with torch.no_grad():
            actions = agent.actor(torch.from_numpy(observations)).argmax(-1)
        observations, rewards, *_ = envs.step(actions.numpy())
        total += rewards.mean()
    envs.close()
    return total / 1000


def train(args: Args) -> Agent:
    """Train an agent."""
    torch.manual_seed(args.seed)
    envs = make(args)
    agent = Agent()
    print(f"untrained policy: {evaluate(agent, args):.4f} a step")
    optimizer = torch.optim.Adam(agent.parameters(), lr=args.learning_rate, eps=1e-5)
    shape = args.num_steps, args.num_envs
    obs, next_values = torch.zeros(*shape, 5), torch.zeros(shape)
    actions, logprobs, rewards, values, dones = (torch.zeros(shape) for _ in range(5))
    next_obs = torch.from_numpy(envs.reset(seed=args.seed)[0])
    updates = args.total_timesteps // (args.num_steps * args.num_envs)
    for update in range(1, updates + 1):
        optimizer.param_groups[0]["lr"] = args.learning_rate * (1 - (update - 1) / updates)
        for step in range(args.num_steps):
            obs[step] = next_obs
            with torch.no_grad():
                policy = agent.policy(next_obs)
                action = policy.sample()
                values[step], logprobs[step], actions[step] = agent.value(next_obs), policy.log_prob(action), action
            observations, reward, _, truncations, infos = envs.step(action.numpy())
            next_obs, rewards[step] = torch.from_numpy(observations), torch.from_numpy(reward)
            # An episode is cut by the time limit, never ended: what its last state is worth goes on to count.
            last = observations.copy()
            if truncations.any():
                last[truncations] = np.stack(infos["final_obs"][truncations])
            with torch.no_grad():
                next_values[step] = agent.value(torch.from_numpy(last))
            dones[step] = torch.from_numpy(truncations)

        advantages, advantage = torch.zeros(shape), torch.zeros(args.num_envs)
        for step in reversed(range(args.num_steps)):
            surprise = rewards[step] + args.gamma * next_values[step] - values[step]
            advantage = surprise + args.gamma * args.gae_lambda * (1 - dones[step]) * advantage
            advantages[step] = advantage
        returns = advantages + values

        for _ in range(args.update_epochs):
            for batch in torch.randperm(obs[..., 0].numel()).chunk(args.num_minibatches):
                rows = batch // args.num_envs, batch % args.num_envs
                policy = agent.policy(obs[rows])
                ratio = (policy.log_prob(actions[rows]) - logprobs[rows]).exp()
                gain = (advantages[rows] - advantages[rows].mean()) / (advantages[rows].std() + 1e-8)
                clipped = ratio.clamp(1 - args.clip_coef, 1 + args.clip_coef)
                policy_loss = -torch.min(ratio * gain, clipped * gain).mean()
                value_loss = 0.5 * (agent.value(obs[rows]) - returns[rows]).square().mean()
                loss = policy_loss - args.ent_coef * policy.entropy().mean() + args.vf_coef * value_loss
                optimizer.zero_grad()
                loss.backward()
                nn.utils.clip_grad_norm_(agent.parameters(), args.max_grad_norm)
                optimizer.step()
        print(f"{update * obs[..., 0].numel():>8} steps: {rewards.mean():.4f} a step while learning")
    envs.close()
    print(f"trained policy: {evaluate(agent, args):.4f} a step")
    return agent


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for each in fields(Args):
        parser.add_argument(f"--{each.name.replace('_', '-')}", type=each.type, default=each.default)
    train(Args(**vars(parser.parse_args())))
